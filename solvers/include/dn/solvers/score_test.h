#pragma once

#include <dn/network.h>
#include <dn/size_prior.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <array>
#include <vector>

namespace dn {

/// How an effect that the network lacks enters one factor: d(whitened residual) / d(effect),
/// residuals x components of the effect.
struct EffectPart {
  FactorId factor = -1;
  Eigen::MatrixXd L;
};

/// A candidate effect. Every part has the same number of columns.
using EffectModel = std::vector<EffectPart>;

/// What the network's residuals say about an effect that it lacks.
struct ScoreTest {
  Eigen::VectorXd estimate;    ///< of the effect's components, to first order
  Eigen::MatrixXd covariance;  ///< of the estimate
  /// Decrease of twice the cost if the effect were estimated: chi-square with `dof` degrees of
  /// freedom when the effect is absent.
  double statistic = 0.0;
  /// Components that the data can tell from the unknowns; where this is less than their number,
  /// estimate and covariance are those of the estimable part (pseudo-inverse).
  int dof = 0;
};

/// Rao's score test of every effect by itself, at the minimum of the cost, without solving anew.
/// With L the effect's columns and r, J, N those of the network (rows weighted and scaled, see
/// LinearizedNetwork::AsRows),
///
///   s = L^T r,  A = L^T L - (J^T L)^T N^-1 (J^T L),  estimate = -A^-1 s,  statistic = s^T A^-1 s.
///
/// Inactive factors take no part. Throws InvalidInput when a part's size does not fit its factor or
/// the effect's other parts.
std::vector<ScoreTest> TestEffects(const Marginals& marginals,
                                   const std::vector<EffectModel>& effects);

/// What the residuals say about several effects at once: every test of one of them, of some
/// together, or of one beside others follows from it without another solution.
struct JointScore {
  std::vector<Eigen::Index> first;  ///< component of each effect's first, and their total at last
  Eigen::VectorXd s;                ///< L^T r
  Eigen::MatrixXd A;                ///< L^T M L, M as in Marginals::Project
  Eigen::VectorXd signature2;       ///< diagonal of L^T L
  /// N^-1 J^T L of the watched blocks, one below the other: how far one unit of a component, in the
  /// data and not in the network, moves them.
  Eigen::MatrixXd shift;

  std::vector<Eigen::Index> Components(std::size_t effect) const;
};

/// The effects' components side by side, in the order given. Throws as TestEffects.
JointScore ScoreEffects(const Marginals& marginals, const std::vector<EffectModel>& effects,
                        const std::vector<BlockId>& watched);
/// The same of effects that stay where they are.
JointScore ScoreEffects(const Marginals& marginals, const std::vector<const EffectModel*>& effects,
                        const std::vector<BlockId>& watched);

/// The score test of components, or of combinations of components, with this s and A (as in
/// JointScore) and the diagonal of their L^T L.
ScoreTest TestScore(const Eigen::VectorXd& s, const Eigen::MatrixXd& A,
                    const Eigen::VectorXd& signature2);

/// The score test of some components together, all others being absent.
ScoreTest TestTogether(const JointScore& score, const std::vector<Eigen::Index>& components);

/// The scores of all components once some are among the unknowns: with index k for those,
///
///   s_j - A_jk A_kk^+ s_k,   A_ij - A_ik A_kk^+ A_kj,   shift_j - shift_k A_kk^+ A_kj.
JointScore GivenComponents(const JointScore& score, const std::vector<Eigen::Index>& components);

/// Log of the likelihood of the residuals with an effect over that without it, averaged over its
/// size. With s and A of its components in units of their usual sizes, A = U diag(d) U^T, c = U^T s,
///
///   log sum_g w_g exp( 1/2 sum_i [ v_g c_i^2 / (1 + v_g d_i) - ln(1 + v_g d_i) ] )
///
/// over the variances v_g and the weights w_g of SizePrior.
class EvidenceForm {
 public:
  /// Of the components W^T s, which have the covariance diag(d) where the effect is absent.
  EvidenceForm() = default;
  /// A: L^T M L of the components, or of as many combinations of them.
  EvidenceForm(const Eigen::MatrixXd& A, const Eigen::VectorXd& typical);

  /// s: L^T r of the same components.
  double LogEvidence(const Eigen::VectorXd& s) const;
  /// Of a variance that is known, in squares of the usual size.
  double LogEvidence(const Eigen::VectorXd& s, double variance) const;

  Eigen::Index size() const { return d_.size(); }

 private:
  /// sum ln(1 + variance d_i)
  double LogGrowth(double variance) const;
  /// sum variance c_i^2 / (1 + variance d_i)
  double Explained(const Eigen::VectorXd& c, double variance) const;

  Eigen::MatrixXd W_;
  Eigen::VectorXd d_;
  std::array<double, SizePrior::kSizes> log_growth_{};  // of the variances v_g
};

/// L^T R of an effect for residuals R of the network (rows x any number).
Eigen::MatrixXd TransposeTimes(const LinearizedNetwork& linearized, const EffectModel& effect,
                               const Eigen::MatrixXd& R);

}  // namespace dn
