#pragma once

#include <dn/network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>

namespace dn {

/// What all other factors say about one factor's residual: the smoothed counterpart of a filter's
/// innovation. With H = J C J^T of the adjustment, w the weight that the factor has in it (the rho'
/// of its robust loss; 0 when it is not active) and r its whitened residual,
///
///   predicted residual  (I - w H)^-1 r,   covariance  I + H (I - w H)^-1.
struct Prediction {
  Eigen::VectorXd residual;
  Eigen::MatrixXd covariance;
  /// residual^T covariance^-1 residual: chi-square with one degree of freedom per residual when the
  /// factor belongs to the model.
  double statistic = 0.0;
  bool determined = true;  ///< false: without the factor the others leave its unknowns free
};

/// The factor may be active or not. `marginals` must have its selected inverse. Throws InvalidInput
/// when it has none, or the factor is undefined.
Prediction PredictFactor(const Marginals& marginals, FactorId factor);

/// Variance that each row of an active factor should have after the fit: its redundancy number
/// diag(I - J C J^T), between 0 (the residual is fitted away) and 1 (the unknowns do not follow
/// it). Divided by its square root, a row of a factor without a robust loss is standard normal when
/// the model holds (Baarda's w). Throws as PredictFactor, and InvalidInput for a factor that is not
/// active.
Eigen::VectorXd RedundancyNumbers(const Marginals& marginals, FactorId factor);

/// The same for every row of the linearised network; they sum to rows minus parameters.
Eigen::VectorXd RedundancyNumbers(const Marginals& marginals);

}  // namespace dn
