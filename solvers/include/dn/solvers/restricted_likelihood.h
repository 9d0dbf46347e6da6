#pragma once

#include <dn/solvers/linearized_network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace dn {

/// The restricted (REML) log likelihood of the noise that a linearised network states: of what its
/// rows say whatever the unknowns are, with r taken to the least-squares solution by one step,
///
///   l = -1/2 (r^T P r + log |V| + log |J^T V^-1 J|),   P = V^-1 - V^-1 J (J^T V^-1 J)^-1 J^T V^-1,
///   V = diag(1 / row_scale^2),
///
/// r and J those of the noise first stated. Up to a constant that depends on the network and the
/// units of its unknowns alone: it is to be compared between scaled copies of one network (see
/// LinearizedNetwork::Scaled).
///
/// Source: Patterson and Thompson (1971), Biometrika 58.
double RestrictedLogLikelihood(const Marginals& marginals);

/// The restricted likelihood of V_ii = 1 + theta share_i (share in units of the stated variance of
/// a row: of those that the network now has, scaled or not), for one theta after another. The factor
/// of the normal matrix is analysed once and filled anew for each, by two threads at most.
class VarianceLikelihood {
 public:
  /// Of the network as it is, which must outlive this. Throws InvalidInput for another number of
  /// rows, or a share that is negative or not finite.
  VarianceLikelihood(const LinearizedNetwork& linearized, const Eigen::VectorXd& share,
                     int threads = 1);
  ~VarianceLikelihood();
  VarianceLikelihood(VarianceLikelihood&&) noexcept;
  VarianceLikelihood& operator=(VarianceLikelihood&&) noexcept;

  /// l(theta), up to a constant that all values of this object share. What was asked for before is
  /// known. Throws InvalidInput for a theta that makes a variance zero or negative; RankDeficient
  /// where the normal matrix cannot be factored.
  std::vector<double> At(const std::vector<double>& thetas);
  double At(double theta) { return At(std::vector<double>{theta})[0]; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How likely other variances are than the stated ones.
struct VarianceProfile {
  std::vector<double> theta;
  std::vector<double> log_likelihood_ratio;  ///< l(theta) - l(0)
};

/// The ratios of VarianceLikelihood. Throws as it does.
VarianceProfile ProfileVariance(const LinearizedNetwork& linearized, const Eigen::VectorXd& share,
                                const std::vector<double>& thetas, int threads = 1);

/// Slope and expected curvature of the restricted likelihood at the stated noise, for several
/// components at once, V = I + sum_k theta_k D_k:
///
///   u_k = 1/2 (r^T M D_k M r - tr(D_k M)),   information_kl = 1/2 tr(D_k M D_l M).
///
/// One Fisher step, information^-1 u, is where the maximum lies when it is near.
struct VarianceScore {
  Eigen::VectorXd u;
  Eigen::MatrixXd information;
};

/// Each column of `shares` is the diagonal of a D_k (rows x components). Exact for at most 400
/// rows; the traces from the samples of ForSampledResiduals for larger networks, at a pair of
/// triangular solves for each sample and one more for each of its components. Throws InvalidInput
/// for another number of rows.
VarianceScore ScoreVariances(const Marginals& marginals, const Eigen::MatrixXd& shares);

}  // namespace dn
