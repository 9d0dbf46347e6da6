#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hypothesis_evidence.h"

namespace dn::diagnosis_internal {

/// A fit of the data with some effects in the model, and the evidence of all others. Sources of
/// residuals add what they need to use the fit.
struct ExtendedFit {
  virtual ~ExtendedFit() = default;

  std::vector<HypothesisEvidence> chosen;   ///< effects in the model, with their joint estimates
  std::vector<HypothesisEvidence> effects;  ///< all others, most probable first
  /// Boresight with the effects that have a prior as unknowns; absent without a boresight.
  std::optional<BoresightEstimate> boresight;
};

/// Fits the data with these effects in the model, and evaluates all others. It may adjust the
/// flight again, or condition scores on the effects.
using Refit = std::function<std::unique_ptr<ExtendedFit>(const std::vector<HypothesisEvidence>&)>;

struct SelectionPolicy {
  double threshold_nats = 0.0;  ///< least evidence of a selected effect
  std::size_t most = 4;         ///< largest number of selected effects
  bool refits = true;           ///< false: selects the first effect without a fit with it
  /// Selects and sizes noise effects again after each further effect. They were estimated before
  /// it was known, and may have absorbed its errors.
  bool resizes_noise = false;
  /// Returns the next effect among those that a fit lacks; null ends the selection.
  std::function<const HypothesisEvidence*(const std::vector<HypothesisEvidence>&)> next = {};
  /// Refines an effect of a fit before it is added to the model. Empty: no refinement.
  std::function<HypothesisEvidence(const ExtendedFit&, const HypothesisEvidence&)> refine = {};
  /// Called before each step with the fraction of the selection done.
  std::function<void(const std::string& stage, double fraction)> progress = {};
};

/// Result of a forward selection: the effects that explain the data.
struct Selection {
  std::unique_ptr<ExtendedFit> base;       ///< without any effects
  std::unique_ptr<ExtendedFit> final;      ///< with all chosen effects; null without such a fit
  std::vector<HypothesisEvidence> chosen;  ///< in the order of selection
  double explained_nats = 0.0;             ///< total evidence of the chosen effects
  std::vector<std::string> notes;

  const ExtendedFit& last() const { return final ? *final : *base; }
};

/// Forward selection of effects. Adds the most probable effect, fits again with it, and repeats
/// while the evidence reaches the threshold.
class ForwardSelection {
 public:
  ForwardSelection(SelectionPolicy policy, Refit refit, std::unique_ptr<ExtendedFit> base);

  /// Adds effects, starting with none.
  void Grow();

  /// Replaces or removes at most one earlier choice: each was made with fewer effects in the model
  /// than now.
  void Revise();

  /// Returns, for each chosen effect, the evidence of all effects given the other chosen ones.
  std::vector<std::vector<HypothesisEvidence>> Alternatives();

  /// Returns the result, once.
  Selection Take() { return std::move(out_); }

 private:
  const HypothesisEvidence* Next(const std::vector<HypothesisEvidence>& effects) const;
  HypothesisEvidence Refined(const ExtendedFit& fit, const HypothesisEvidence& effect) const;
  void ShowProgress(const std::string& stage, double fraction) const;
  std::unique_ptr<ExtendedFit> TryFit(const std::vector<HypothesisEvidence>& chosen);
  void ReconsiderNoise();
  std::vector<HypothesisEvidence> Without(std::size_t k) const;
  const ExtendedFit* FitWithout(std::size_t k);
  void Replace(const std::vector<HypothesisEvidence>& chosen);

  SelectionPolicy policy_;
  Refit refit_;
  Selection out_;
  // Earlier fits, in order: with the first effect, with the first two effects, and so on.
  std::vector<std::unique_ptr<ExtendedFit>> before_;
  std::unique_ptr<ExtendedFit> scratch_;
  // Evidence of all effects given the chosen ones but one, for choices that were confirmed.
  std::map<std::size_t, std::vector<HypothesisEvidence>> confirmed_;
  bool revised_ = false;
};

}  // namespace dn::diagnosis_internal
