#pragma once

#include <dn/builder/flight_network.h>
#include <dn/gap/diagnosis.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "library.h"

namespace dn::internal {

/// What the data say about one effect: that of its windows, starts and time constants which explains
/// them best. SI.
struct ScreenedEffect {
  std::string name;
  std::optional<EffectId> id;  ///< absent for a discrepancy without a physical name
  EffectTimes times;
  std::optional<double> period_s;
  std::optional<double> decay_s;
  double log_evidence = 0.0;  ///< averaged over sizes, windows and time constants
  double p_value = 1.0;       ///< of the best, times the number of those tried
  double statistic = 0.0;     ///< of the best, chi-square; 0 of a process
  Eigen::VectorXd estimate;   ///< of a process: sigmas, then tau
  Eigen::VectorXd sigma;      ///< NaN of a tau
  double absorbed = 0.0;      ///< share of the signature that the unknowns follow
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  std::size_t candidate = 0;  ///< of the library

  bool physical() const { return id.has_value(); }
};

/// An effect of the table about which nothing is known yet.
ScreenedEffect Unscreened(EffectId id);

/// The likeliest first.
void SortByEvidence(std::vector<ScreenedEffect>* effects);

/// An effect as the reports have it: in the units of the table.
GapCause ToCause(const ScreenedEffect& effect);

/// Effects with the same name.
struct EffectFamily {
  std::string name;
  std::optional<EffectId> id;       ///< absent for discrepancies
  std::size_t first = 0, past = 0;  ///< candidates
};

/// The scores of a library at a solved network.
class Screen {
 public:
  /// Throws as ScoreEffects.
  Screen(const FlightNetwork& network, const Marginals& marginals, const LibraryOptions& options);
  /// Of scores that are known; the library needs no blocks.
  Screen(Library library, JointScore score);

  const Library& library() const { return library_; }
  const JointScore& score() const { return score_; }
  const std::vector<EffectFamily>& families() const { return families_; }

  /// L^T R of all columns, for residuals R of the network.
  Eigen::MatrixXd Scores(const LinearizedNetwork& linearized, const Eigen::MatrixXd& R) const;

  /// Log evidence of a family for the scores s of all columns.
  double LogEvidence(const EffectFamily& family, const Eigen::VectorXd& s) const;

  /// Of every family with the network's own residuals, the likeliest first.
  std::vector<ScreenedEffect> Effects() const;
  /// The same in the order of the families.
  std::vector<ScreenedEffect> EffectsInOrder() const;

  /// The evidence of a candidate by its own scores.
  const EvidenceForm& form(std::size_t candidate) const { return forms_[candidate]; }

  /// The test of one candidate for the scores s.
  ScoreTest Test(std::size_t candidate, const Eigen::VectorXd& s) const;

 private:
  void MakeForms();
  double LogEvidence(std::size_t candidate, const Eigen::VectorXd& s) const;
  ScreenedEffect Describe(const EffectFamily& family) const;
  void DescribeProcess(const Candidate& candidate, std::size_t index, ScreenedEffect* effect) const;
  void DescribeFixed(const Candidate& candidate, std::size_t index, ScreenedEffect* effect) const;

  Library library_;
  JointScore score_;
  std::vector<EvidenceForm> forms_;  // of the candidates
  std::vector<EffectFamily> families_;
};

}  // namespace dn::internal
