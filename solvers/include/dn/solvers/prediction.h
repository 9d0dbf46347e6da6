#pragma once

#include <dn/network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>

namespace dn {

/// Prediction of one factor's residual from all other factors: the smoothing counterpart of a
/// filter's innovation. Let H = J C J^T of the adjustment and r the whitened residual of the
/// factor. Its weight w is the rho' of its robust loss; 0 if it is not active. Then
///
///   predicted residual  (I - w H)^-1 r,   covariance  I + H (I - w H)^-1.
struct Prediction {
  Eigen::VectorXd residual;
  Eigen::MatrixXd covariance;
  /// The statistic residual^T covariance^-1 residual. It is chi-square with one degree of freedom
  /// per residual if the factor agrees with the model.
  double statistic = 0.0;
  bool determined = true;  ///< false if the other factors alone leave its unknowns undetermined
};

/// Predicts the residual of a factor, which may be active or not. Throws InvalidInput if the
/// selected inverse of `marginals` has not been computed, or if the factor is undefined.
Prediction PredictFactor(const Marginals& marginals, FactorId factor);

/// Returns the redundancy numbers of the rows of an active factor, diag(I - J C J^T). They are the
/// expected variances of its whitened residuals after the fit. They lie between 0 (the fit absorbs
/// the residual) and 1 (the unknowns do not depend on it). Without a robust loss, a residual
/// divided by the square root of its redundancy number is standard normal if the model holds
/// (Baarda's w). Throws as PredictFactor does, and InvalidInput for a factor that is not active.
Eigen::VectorXd RedundancyNumbers(const Marginals& marginals, FactorId factor);

/// Returns the redundancy number of every row of the linearised network. Their sum is the number of
/// rows minus the number of parameters.
Eigen::VectorXd RedundancyNumbers(const Marginals& marginals);

}  // namespace dn
