#pragma once

#include <dn/noise.h>

#include <string>

namespace dn::builder_internal {

/// Returns the noise of one measurement. Throws InvalidInput with `what`, its time and the advice
/// `check` if the covariance is not finite, or not symmetric and positive definite.
Noise<3> MeasurementNoise(const Eigen::Matrix3d& covariance, const std::string& what, double t_s,
                          const std::string& check);

}  // namespace dn::builder_internal
