#include <dn/builder/measurement_noise.h>
#include <fmt/format.h>

namespace dn::builder_internal {

Noise<3> MeasurementNoise(const Eigen::Matrix3d& covariance, const std::string& what, double t_s,
                          const std::string& check) {
  try {
    return Noise<3>::Covariance(covariance);
  } catch (const InvalidInput&) {
    throw InvalidInput(fmt::format("the covariance of {} at t = {:.3f} s is {}; {}", what, t_s,
                                   covariance.allFinite() ? "not positive definite" : "not finite",
                                   check));
  }
}

}  // namespace dn::builder_internal
