#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "hypothesis_evidence.h"
#include "library.h"

namespace dn::diagnosis_internal {

/// Candidates with the same name.
struct EffectFamily {
  std::string name;
  std::optional<EffectId> id;       ///< nullopt for discrepancies
  std::size_t first = 0, past = 0;  ///< range of candidates
};

/// Screening of a library of effects by their scores at a solved network, without refits.
class Screen {
 public:
  /// Throws as ScoreEffects.
  Screen(const FlightNetwork& network, const Marginals& marginals, const LibraryOptions& options);
  /// Uses known scores; the library needs no blocks.
  Screen(Library library, JointScore score);

  const Library& library() const { return library_; }
  const JointScore& score() const { return score_; }
  const std::vector<EffectFamily>& families() const { return families_; }

  /// Returns L^T R of all columns L, for residuals R of the network.
  Eigen::MatrixXd Scores(const LinearizedNetwork& linearized, const Eigen::MatrixXd& R) const;

  /// Returns the log evidence of all families for the scores s of all columns.
  Eigen::VectorXd LogEvidences(const Eigen::VectorXd& s) const;

  /// Returns all families for the network's own residuals, most probable first.
  std::vector<HypothesisEvidence> Effects() const;
  /// Returns all families in their own order, instead of by probability.
  std::vector<HypothesisEvidence> EffectsInOrder() const;

  /// Returns the evidence of a candidate as a function of its own scores.
  const SizeAveragedEvidence& form(std::size_t candidate) const { return forms_[candidate]; }

 private:
  void MakeForms();
  double LogEvidence(std::size_t candidate, const Eigen::VectorXd& s) const;
  double LogEvidence(const EffectFamily& family, const Eigen::VectorXd& s) const;
  HypothesisEvidence Describe(const EffectFamily& family) const;
  void EstimateProcess(const SizeAveragedEvidence& form, HypothesisEvidence* effect) const;

  Library library_;
  JointScore score_;
  std::vector<SizeAveragedEvidence> forms_;  // one per candidate
  std::vector<EffectFamily> families_;
};

}  // namespace dn::diagnosis_internal
