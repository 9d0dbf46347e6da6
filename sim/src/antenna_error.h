#pragma once

#include <dn/gnss/gnss_process.h>
#include <dn/sim/random.h>

#include <Eigen/Core>
#include <optional>

namespace dn {

/// Simulates an error of the antenna position as a Gauss-Markov process in continuous time. The
/// epochs of the calls must increase.
class AntennaError {
 public:
  AntennaError(const GnssProcess& process, const Random& random);

  /// Returns the error at t_s in local east, north, up, m.
  Eigen::Vector3d operator()(double t_s);

 private:
  GnssProcess process_;
  Random random_;
  Eigen::Vector3d state_;  // in units of the standard deviations
  std::optional<double> last_s_;
};

}  // namespace dn
