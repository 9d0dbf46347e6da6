#pragma once

#include <dn/network.h>
#include <dn/size_prior.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <array>
#include <vector>

namespace dn {

/// Derivative of one factor with respect to an effect that the network does not model: d(whitened
/// residual) / d(effect), residuals x components of the effect.
struct EffectPart {
  FactorId factor = -1;
  Eigen::MatrixXd L;
};

/// A candidate effect: its derivatives for each affected factor, all with the same number of
/// columns.
using EffectModel = std::vector<EffectPart>;

/// Score test of an effect that the network does not model.
struct ScoreTest {
  Eigen::VectorXd estimate;    ///< first-order estimate of the effect's components
  Eigen::MatrixXd covariance;  ///< covariance of the estimate
  /// Decrease of twice the cost if the effect were estimated. It is chi-square with `dof` degrees
  /// of freedom if the effect is absent.
  double statistic = 0.0;
  /// Number of components that the data can separate from the unknowns. If it is smaller than the
  /// number of components, estimate and covariance describe the estimable part (pseudo-inverse).
  int dof = 0;
};

/// Computes Rao's score test of each effect separately, at the minimum of the cost, without solving
/// the network again. L are the effect's columns, and r, J, N those of the network (rows weighted
/// and scaled, see ToRowScaling):
///
///   s = L^T r,  A = L^T L - (J^T L)^T N^-1 (J^T L),  estimate = -A^-1 s,  statistic = s^T A^-1 s.
///
/// Inactive factors are ignored. Throws InvalidInput if the size of a part does not fit its factor
/// or the other parts of the effect.
std::vector<ScoreTest> TestEffects(const Marginals& marginals,
                                   const std::vector<EffectModel>& effects);

/// Joint scores of several effects. Tests of one effect, of several together, or of one given
/// others follow from them without another solution.
struct JointScore {
  /// First component of each effect, followed by the total number of components.
  std::vector<Eigen::Index> first;
  Eigen::VectorXd s;           ///< L^T r
  Eigen::MatrixXd A;           ///< L^T M L, M as in Marginals::Project
  Eigen::VectorXd signature2;  ///< diagonal of L^T L
  /// N^-1 J^T L of the watched blocks, one below the other. It is the shift of these blocks per
  /// unit of a component that is present in the data but not in the network.
  Eigen::MatrixXd shift;

  std::vector<Eigen::Index> Components(std::size_t effect) const;
};

/// Computes the joint scores of the effects, with their components in the order given. Throws as
/// TestEffects does.
JointScore ScoreEffects(const Marginals& marginals, const std::vector<EffectModel>& effects,
                        const std::vector<BlockId>& watched);
/// Computes the same scores for effects given by pointer, without copying them.
JointScore ScoreEffects(const Marginals& marginals, const std::vector<const EffectModel*>& effects,
                        const std::vector<BlockId>& watched);

/// Returns the score test of components, or of linear combinations of components. s and A are as in
/// JointScore; signature2 is the diagonal of their L^T L.
ScoreTest TestScore(const Eigen::VectorXd& s, const Eigen::MatrixXd& A,
                    const Eigen::VectorXd& signature2);

/// Returns the score test of some components together while all others are absent.
ScoreTest TestJointly(const JointScore& score, const std::vector<Eigen::Index>& components);

/// Returns the score test of linear combinations of the components, the columns of T.
ScoreTest TestCombinations(const JointScore& score, const Eigen::MatrixXd& T);

/// Returns the scores of all components after linear combinations of them, the columns of T, have
/// become unknowns. With A_T = T^T A T:
///
///   s - A T A_T^+ T^T s,   A - A T A_T^+ T^T A,   shift - shift T A_T^+ T^T A.
JointScore ConditionOn(const JointScore& score, const Eigen::MatrixXd& T);

/// Mean and covariance of linear functions of an effect.
struct LinearMoments {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

/// Log Bayes factor of an effect. It is the log of the likelihood of the residuals with the effect
/// over that without it, averaged over the prior of the effect's size. With s and A of its
/// components in units of their typical sizes, A = U diag(d) U^T, c = U^T s,
///
///   log sum_g w_g exp( 1/2 sum_i [ v_g c_i^2 / (1 + v_g d_i) - ln(1 + v_g d_i) ] )
///
/// over the variances v_g and the weights w_g of SizePrior.
class SizeAveragedEvidence {
 public:
  /// Creates the form of an effect without components; LogEvidence is then 0.
  SizeAveragedEvidence() = default;
  /// Creates the form from A, the L^T M L of the components or of linear combinations of them, and
  /// their typical sizes.
  SizeAveragedEvidence(const Eigen::MatrixXd& A, const Eigen::VectorXd& typical);

  /// Returns the log Bayes factor for s, the L^T r of the same components.
  double LogEvidence(const Eigen::VectorXd& s) const;
  /// Returns the log Bayes factor if the variance of the effect is known, in squares of the typical
  /// size.
  double LogEvidence(const Eigen::VectorXd& s, double variance) const;

  /// Returns the posterior moments of F e for the effect e, averaged over the same sizes. W are the
  /// columns of U in typical sizes. Given v_g, e has the mean -W c v_g / (1 + v_g d) and the
  /// covariance W diag(v_g / (1 + v_g d)) W^T.
  LinearMoments Moments(const Eigen::VectorXd& s, const Eigen::MatrixXd& F) const;

  Eigen::Index size() const { return d_.size(); }

 private:
  /// Returns sum ln(1 + variance d_i).
  double LogGrowth(double variance) const;
  /// Returns sum variance c_i^2 / (1 + variance d_i).
  double Explained(const Eigen::VectorXd& c, double variance) const;

  Eigen::MatrixXd W_;
  Eigen::VectorXd d_;
  std::array<double, SizePrior::kSizes> log_growth_{};  // LogGrowth of the variances v_g
};

/// Returns L^T R of an effect for residuals R of the network (rows x any number of columns).
Eigen::MatrixXd TransposeTimes(const LinearizedNetwork& linearized, const EffectModel& effect,
                               const Eigen::MatrixXd& R);

}  // namespace dn
