#pragma once

#include <dn/network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
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
/// With L the effect's columns and r, J, N those of the network (weighted by rho'),
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

/// The score test of some components together, all others being absent.
ScoreTest TestTogether(const JointScore& score, const std::vector<Eigen::Index>& components);

/// The scores of all components once some are among the unknowns: with index k for those,
///
///   s_j - A_jk A_kk^+ s_k,   A_ij - A_ik A_kk^+ A_kj,   shift_j - shift_k A_kk^+ A_kj.
JointScore GivenComponents(const JointScore& score, const std::vector<Eigen::Index>& components);

}  // namespace dn
