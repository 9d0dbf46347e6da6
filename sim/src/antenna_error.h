#pragma once

#include <dn/gnss/gnss_process.h>
#include <dn/sim/random.h>

#include <Eigen/Core>
#include <optional>

namespace dn {

/// An error of the antenna position, Gauss-Markov in continuous time, taken at rising epochs.
class AntennaError {
 public:
  AntennaError(const GnssProcess& process, const Random& random);

  /// Local east, north, up, m.
  Eigen::Vector3d operator()(double t_s);

 private:
  GnssProcess process_;
  Random random_;
  Eigen::Vector3d state_;  // in sigmas
  std::optional<double> last_s_;
};

}  // namespace dn
