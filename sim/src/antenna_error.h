#pragma once

#include <dn/gnss/gnss_process.h>
#include <dn/sim/random.h>

#include <Eigen/Core>
#include <optional>

namespace dn {

/// Simulates an error of the antenna position as a Gauss-Markov process x in continuous time. The
/// epochs of the calls must increase. An error that grows with the bank is
///
///   e = |roll| / 30 deg  diag(sigma_enu) x,      x [3]: unit variance, correlation exp(-dt / tau)
///
/// Reason for the linear law: an antenna that banks sees a part of the sky past wing and tail. This
/// part lies between the horizon and the plane of the antenna, and is |roll| / 180 deg of the sky.
/// The process itself continues in level flight, as the geometry of the satellites does.
class AntennaError {
 public:
  AntennaError(const GnssProcess& process, const Random& random);

  /// Returns the error at t_s, at a true roll, in local east, north, up, m.
  Eigen::Vector3d operator()(double t_s, double roll_rad);

 private:
  GnssProcess process_;
  Random random_;
  Eigen::Vector3d state_;  // in units of the standard deviations
  std::optional<double> last_s_;
};

}  // namespace dn
