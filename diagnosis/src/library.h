#pragma once

#include <dn/builder/flight_network.h>
#include <dn/effects/effect_table.h>
#include <dn/files/effect_times.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn::internal {

/// A range of cells of a block, which share one value (sum of their columns) or have one value
/// each.
struct CellRange {
  int first = 0, past = 0;
  int width = 3;  ///< columns per cell
  bool in_common = true;

  /// Reduces X, which has one row for each column of the block, to the rows of the range.
  Eigen::MatrixXd Rows(const Eigen::Ref<const Eigen::MatrixXd>& X) const;
};

/// A hypothesis on how the data may differ from the model: columns of a block, or sums of them. The
/// values are Gaussian with the typical sizes times a common factor.
struct Candidate {
  std::string name;            ///< name of the effect, or description of the discrepancy
  std::optional<EffectId> id;  ///< nullopt for an unmodelled discrepancy
  EffectTimes times;
  std::optional<double> tau_s;     ///< time constant of a process; its columns are cosines
  std::size_t block = 0;           ///< index in Library::blocks
  std::optional<CellRange> cells;  ///< nullopt: all columns of the block
  std::optional<double> period_s;  ///< period of an oscillation
  std::optional<double> decay_s;   ///< time constant of a decay
  Eigen::VectorXd typical;         ///< typical size of each component, SI
  std::string unit;
  double per_si = 1.0;
};

/// The effects that a flight is tested for, with their derivatives at the network's values.
struct Library {
  std::vector<EffectModel> blocks;
  std::vector<Candidate> candidates;  ///< those with the same name are adjacent
};

/// The effects to be tested.
struct LibraryOptions {
  std::vector<std::string> effects;   ///< only these; empty: all
  std::vector<std::string> left_out;  ///< all but these
  int threads = 1;

  bool Wanted(const std::string& effect) const;
  bool Wanted(EffectId effect) const { return Wanted(EffectName(effect)); }
};

/// Makes the library of a flight: all fixed effects with their possible windows and starts,
/// processes expressed by cosines, and unmodelled discrepancies.
Library MakeLibrary(const FlightNetwork& network, const LinearizedNetwork& linearized,
                    const LibraryOptions& options);

/// Returns an unmodelled discrepancy of all columns of a block.
Candidate MakeDiscrepancy(const std::string& name, std::size_t block,
                          const Eigen::VectorXd& typical);

/// Adds a decaying discrepancy for each time constant of a BoresightSettling block.
void AddSettling(const std::string& name, std::size_t block, const std::vector<double>& taus_s,
                 const Eigen::VectorXd& typical, Library* library);

/// Returns the columns of a candidate.
EffectModel CandidateModel(const Candidate& candidate, const Library& library);

/// Returns the part of the joint score s that belongs to a candidate.
Eigen::VectorXd CandidateScore(const Candidate& candidate, const JointScore& score,
                               const Eigen::VectorXd& s);
/// Returns the information matrix of a candidate.
Eigen::MatrixXd CandidateInformation(const Candidate& candidate, const JointScore& score);
/// Returns the cross information of two candidates.
Eigen::MatrixXd CandidateInformation(const Candidate& a, const Candidate& b,
                                     const JointScore& score);
/// Returns the diagonal of L^T L of a candidate's columns L.
Eigen::VectorXd CandidateSignature(const Candidate& candidate, const JointScore& score);
/// Returns the shift of the watched unknowns per unit of each component.
Eigen::MatrixXd CandidateShift(const Candidate& candidate, const JointScore& score);

}  // namespace dn::internal
