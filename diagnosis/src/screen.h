#pragma once

#include <dn/builder/flight_network.h>
#include <dn/diagnosis/diagnosis.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "library.h"

namespace dn::internal {

/// Evidence for one effect, with the window, start and time constant that explain the data best.
/// SI.
struct ScreenedEffect {
  std::string name;
  std::optional<EffectId> id;  ///< nullopt for an unmodelled discrepancy
  EffectTimes times;
  std::optional<double> period_s;
  std::optional<double> decay_s;
  double log_evidence = 0.0;  ///< averaged over sizes, windows and time constants
  double p_value = 1.0;       ///< of the best candidate, times the number of candidates
  double statistic = 0.0;     ///< chi-square of the best candidate; 0 for a process
  Eigen::VectorXd estimate;   ///< for a process: sigmas, then tau
  Eigen::VectorXd sigma;      ///< NaN for a tau
  double absorbed = 0.0;      ///< fraction of the signature that the unknowns absorb
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  std::size_t candidate = 0;  ///< index in the library

  bool physical() const { return id.has_value(); }
};

/// Returns an effect of the table without any evidence.
ScreenedEffect MakeUnscreened(EffectId id);

/// Sorts effects by evidence, most probable first.
void SortByEvidence(std::vector<ScreenedEffect>* effects);

/// Converts an effect to the units of the table.
GapCause ToCause(const ScreenedEffect& effect);

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

  /// Returns the log evidence of a family for the scores s of all columns.
  double LogEvidence(const EffectFamily& family, const Eigen::VectorXd& s) const;

  /// Returns all families for the network's own residuals, most probable first.
  std::vector<ScreenedEffect> Effects() const;
  /// Returns all families in their own order, instead of by probability.
  std::vector<ScreenedEffect> EffectsInOrder() const;

  /// Returns the evidence of a candidate as a function of its own scores.
  const SizeAveragedEvidence& form(std::size_t candidate) const { return forms_[candidate]; }

  /// Tests one candidate with the scores s of all columns.
  ScoreTest Test(std::size_t candidate, const Eigen::VectorXd& s) const;

 private:
  void MakeForms();
  double LogEvidence(std::size_t candidate, const Eigen::VectorXd& s) const;
  ScreenedEffect Describe(const EffectFamily& family) const;
  void DescribeProcess(const Hypothesis& hypothesis, std::size_t index,
                       ScreenedEffect* effect) const;
  void DescribeFixed(const Hypothesis& hypothesis, std::size_t index, ScreenedEffect* effect) const;

  Library library_;
  JointScore score_;
  std::vector<SizeAveragedEvidence> forms_;  // one per candidate
  std::vector<EffectFamily> families_;
};

}  // namespace dn::internal
