#pragma once

#include <dn/builder/flight_network.h>
#include <dn/effects/effect_table.h>
#include <dn/flight/effect_times.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn::internal {

/// Cells of a block that have one value in common, sum of their columns, or each one of its own.
struct CellRange {
  int first = 0, past = 0;
  int width = 3;  ///< columns of a cell
  bool in_common = true;

  /// X of the columns of all cells, one per row, reduced to those of the range.
  Eigen::MatrixXd Rows(const Eigen::Ref<const Eigen::MatrixXd>& X) const;
};

/// One way in which the data may depart from the model: columns of a block, or sums of them, whose
/// values are Gaussian of the usual sizes times a common factor.
struct Candidate {
  std::string name;            ///< of the effect, or a description of the discrepancy
  std::optional<EffectId> id;  ///< absent for a discrepancy without a physical name
  EffectTimes times;
  std::optional<double> tau_s;     ///< of a process: its columns are cosines
  std::size_t block = 0;           ///< of Library::blocks
  std::optional<CellRange> cells;  ///< absent: all columns of the block
  std::optional<double> period_s;  ///< of an oscillation
  std::optional<double> decay_s;   ///< of what settles: its time constant
  Eigen::VectorXd typical;         ///< usual size of each component, SI
  std::string unit;
  double per_si = 1.0;
};

/// The effects that a flight is searched for, with their derivatives at the network's values.
struct Library {
  std::vector<EffectModel> blocks;
  std::vector<Candidate> candidates;  ///< those of one name side by side
};

/// Which effects are searched for.
struct LibraryOptions {
  std::vector<std::string> effects;   ///< only these; empty: all
  std::vector<std::string> left_out;  ///< not these
  int threads = 1;

  bool Wanted(const std::string& effect) const;
  bool Wanted(EffectId effect) const { return Wanted(EffectName(effect)); }
};

/// All fixed effects, with the windows and starts that the flight has room for; processes by their
/// cosines; discrepancies without a name.
Library MakeLibrary(const FlightNetwork& network, const LinearizedNetwork& linearized,
                    const LibraryOptions& options);

/// A discrepancy of all columns of a block.
Candidate Nameless(const std::string& name, std::size_t block, const Eigen::VectorXd& typical);

/// Adds one candidate of a discrepancy for each time constant of a BoresightSettling block.
void AddSettling(const std::string& name, std::size_t block, const std::vector<double>& taus_s,
                 const Eigen::VectorXd& typical, Library* library);

/// The columns of a candidate by themselves.
EffectModel ModelOf(const Candidate& candidate, const Library& library);

/// The part of a statistic that a candidate is about.
Eigen::VectorXd ScoreOf(const Candidate& candidate, const JointScore& score,
                        const Eigen::VectorXd& s);
Eigen::MatrixXd InformationOf(const Candidate& candidate, const JointScore& score);
/// Cross information of two candidates.
Eigen::MatrixXd InformationOf(const Candidate& a, const Candidate& b, const JointScore& score);
/// Diagonal of L^T L.
Eigen::VectorXd SignatureOf(const Candidate& candidate, const JointScore& score);
/// How far one unit of each component moves what the score watches.
Eigen::MatrixXd ShiftOf(const Candidate& candidate, const JointScore& score);

}  // namespace dn::internal
