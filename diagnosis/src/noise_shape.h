#pragma once

#include <Eigen/Core>
#include <vector>

namespace dn::diagnosis_internal {

/// Two descriptions of residuals with heavy tails, both by maximum likelihood.
struct NoiseShape {
  /// Log likelihood of normal noise of any size with outliers, less that of Student's t. Each is
  /// less half the log of the number of residuals per parameter (Schwarz).
  double outlier_lead_nats = 0.0;
  double dof = 0.0;    ///< degrees of freedom of Student's t
  double scale = 1.0;  ///< its scale, in sigmas of the stated noise
};

/// Compares both descriptions of residuals in sigmas of the stated noise, one vector per
/// measurement. Outliers have random directions, and lengths that are uniform up to the longest
/// residual. The components of Student's t are independent, or have one common tail.
NoiseShape CompareNoiseShapes(const std::vector<Eigen::Vector3d>& residuals);

}  // namespace dn::diagnosis_internal
