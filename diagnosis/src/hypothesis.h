#pragma once

#include <dn/builder/calibration_effect.h>
#include <dn/effects/effect_table.h>
#include <dn/files/effect_times.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace dn::diagnosis_internal {

/// A range of cells of a block, which share one value (sum of their columns) or have one value
/// each.
struct CellRange {
  int first = 0, past = 0;
  int width = 3;  ///< columns per cell
  bool in_common = true;

  /// Reduces X, which has one row for each column of the block, to the rows of the range.
  Eigen::MatrixXd Rows(const Eigen::Ref<const Eigen::MatrixXd>& X) const;
};

/// A hypothesis on how the data may differ from the model: an effect of the table, or an unmodelled
/// discrepancy. Its columns are those of a block, or sums of them. The values are Gaussian with the
/// typical sizes times a common factor.
struct Hypothesis {
  std::string name;            ///< name of the effect, or description of the discrepancy
  std::optional<EffectId> id;  ///< nullopt for an unmodelled discrepancy
  EffectTimes times;
  std::optional<double> tau_s;     ///< time constant of a process; its columns are cosines
  std::size_t block = 0;           ///< index in Library::blocks
  std::optional<CellRange> cells;  ///< nullopt: all columns of the block
  std::optional<double> period_s;  ///< period of an oscillation
  std::optional<double> decay_s;   ///< time constant of a decay
  Eigen::VectorXd typical;         ///< typical size of each component, SI
  std::string unit = "1";          ///< unit of reported values
  double per_si = 1.0;             ///< reported = SI value * per_si
  std::string remedy;              ///< proposed correction or estimate, with the keys' names
  EffectAction action;             ///< null: the effect is a block of every network, or a process

  /// Returns the index of each component in a joint score of the blocks; without cells only.
  std::vector<Eigen::Index> Components(const JointScore& score) const {
    return score.Components(block);
  }
};

/// Returns an effect of the table without times and action.
Hypothesis MakeHypothesis(EffectId id, std::size_t block = 0);
/// Returns an effect of the estimator as it acts at a site.
Hypothesis MakeHypothesis(const EstimableEffect& effect, const EffectSite& site);
/// Returns an unmodelled discrepancy. All its components have one typical size.
Hypothesis MakeDiscrepancy(const std::string& name, EffectAction action, Eigen::Index components,
                           double typical);
/// Returns a discrepancy of a part of the columns of another one.
Hypothesis MakeDiscrepancy(const std::string& name, std::size_t block, const CellRange& cells,
                           const Eigen::VectorXd& typical);

/// The hypotheses that a flight is tested for, with their derivatives at the network's values.
struct Library {
  std::vector<EffectModel> blocks;
  std::vector<Hypothesis> hypotheses;  ///< those with the same name are adjacent

  /// Adds columns. Returns the index of their block.
  std::size_t AddBlock(EffectModel columns);
  /// Adds a hypothesis with its own block.
  void Add(Hypothesis hypothesis, EffectModel columns);
};

/// Returns the columns of a hypothesis.
EffectModel SelectColumns(const Hypothesis& hypothesis, const Library& library);

/// These functions select the part of a joint score that belongs to a hypothesis: scores s,
/// information, diagonal of L^T L of its columns L. The last one is the shift of the watched
/// unknowns per unit of each component.
Eigen::VectorXd SelectScore(const Hypothesis& hypothesis, const JointScore& score,
                            const Eigen::VectorXd& s);
Eigen::MatrixXd SelectInformation(const Hypothesis& hypothesis, const JointScore& score);
Eigen::VectorXd SelectSignature(const Hypothesis& hypothesis, const JointScore& score);
Eigen::MatrixXd SelectShift(const Hypothesis& hypothesis, const JointScore& score);
/// Returns the cross information of two hypotheses.
Eigen::MatrixXd SelectInformation(const Hypothesis& a, const Hypothesis& b,
                                  const JointScore& score);

}  // namespace dn::diagnosis_internal
