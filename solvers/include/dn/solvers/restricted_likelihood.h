#pragma once

#include <dn/solvers/linearized_network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace dn {

/// Returns the restricted (REML) log likelihood of the noise model of a linearised network. It is
/// the likelihood of that part of the rows that does not depend on the unknowns. r is first moved
/// to the least-squares solution by one step,
///
///   l = -1/2 (r^T P r + log |V| + log |J^T V^-1 J|),   P = V^-1 - V^-1 J (J^T V^-1 J)^-1 J^T V^-1,
///   V = diag(1 / row_scale^2).
///
/// r and J are those of the original noise. The value is known up to a constant that depends only
/// on the network and the units of its unknowns. Compare it only between scaled copies of one
/// network (see LinearizedNetwork::Scaled).
///
/// Source: Patterson and Thompson (1971), Biometrika 58.
double RestrictedLogLikelihood(const Marginals& marginals);

/// The restricted likelihood of V_ii = 1 + theta share_i, evaluated for many values of theta.
/// share_i is in units of the variance that row i of the given network has, scaled or not. The
/// pattern of the normal matrix is analysed once; each theta costs one numeric factorisation, with
/// at most two threads.
class VarianceLikelihood {
 public:
  /// Prepares the likelihood of `linearized`, which must outlive this object. Throws InvalidInput
  /// for a wrong number of rows, or a share that is negative or not finite.
  VarianceLikelihood(const LinearizedNetwork& linearized, const Eigen::VectorXd& share,
                     int threads = 1);
  ~VarianceLikelihood();
  VarianceLikelihood(VarianceLikelihood&&) noexcept;
  VarianceLikelihood& operator=(VarianceLikelihood&&) noexcept;

  /// Returns l(theta) up to a constant that all values of this object share. Earlier values are
  /// cached. Throws InvalidInput for a theta that makes a variance zero or negative; RankDeficient
  /// if the normal matrix cannot be factored.
  std::vector<double> At(const std::vector<double>& thetas);
  double At(double theta) { return At(std::vector<double>{theta})[0]; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Likelihood ratios of other variances against the stated ones.
struct VarianceProfile {
  std::vector<double> theta;
  std::vector<double> log_likelihood_ratio;  ///< l(theta) - l(0)
};

/// Returns the likelihood ratios at `thetas`. Throws as VarianceLikelihood does.
VarianceProfile ProfileVariance(const LinearizedNetwork& linearized, const Eigen::VectorXd& share,
                                const std::vector<double>& thetas, int threads = 1);

/// Gradient and expected information of the restricted likelihood at the stated noise, for several
/// variance components, V = I + sum_k theta_k D_k:
///
///   u_k = 1/2 (r^T M D_k M r - tr(D_k M)),   information_kl = 1/2 tr(D_k M D_l M).
///
/// One Fisher scoring step, information^-1 u, approximates the maximum if it is near.
struct VarianceScore {
  Eigen::VectorXd u;
  Eigen::MatrixXd information;
};

/// Returns the score of the components whose diagonals D_k are the columns of `shares` (rows x
/// components). The result is exact for at most 400 rows. Larger networks estimate the traces from
/// the samples of ForEachSampledResidual, with one pair of triangular solves per sample and one
/// more per sample and component. Throws InvalidInput for a wrong number of rows.
VarianceScore ScoreVariances(const Marginals& marginals, const Eigen::MatrixXd& shares);

}  // namespace dn
