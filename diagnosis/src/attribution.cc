#include "attribution.h"

#include <dn/effects/effect_table.h>
#include <dn/interrupted.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "decision.h"
#include "refine_times.h"

namespace dn::internal {
namespace {

class ForwardSelection {
 public:
  ForwardSelection(const ExtendedModelFitter& model_fitter, std::unique_ptr<ExtendedFit> base,
                   double threshold_nats)
      : fitter_(model_fitter), threshold_nats_(threshold_nats) {
    out_.base = std::move(base);
  }

  SelectedModel Run(bool detected) {
    fitter_.EvaluateProcesses(out_.base.get());
    out_.discrepancy_nats = DiscrepancyEvidence(out_.base->effects);
    if (detected) {
      Grow();
      if (out_.causes.size() > 1) Revise();
    }
    MakeAllHypotheses();
    return std::move(out_);
  }

 private:
  const ExtendedFit& Current() const { return out_.last(); }

  GapCause Refined(const ExtendedFit& explained, ScreenedEffect effect) const {
    RefineTimes(explained.solution->network(), explained.solution->marginals(),
                fitter_.options().threads, &effect);
    return ToCause(effect);
  }

  void Report(const std::string& stage, double fraction) const {
    if (fitter_.options().progress) fitter_.options().progress(stage, fraction);
  }

  /// Adjusts the flight with these causes. Returns null and adds a note if it cannot be adjusted.
  std::unique_ptr<ExtendedFit> TryFit(const std::vector<GapCause>& causes) {
    try {
      auto explained = std::make_unique<ExtendedFit>(fitter_.Explain(causes));
      fitter_.EvaluateProcesses(explained.get());
      return explained;
    } catch (const Interrupted&) {
      throw;
    } catch (const std::exception& error) {
      out_.notes.push_back("the flight cannot be adjusted with " + causes.back().effect +
                           " among the unknowns: " + error.what());
      return nullptr;
    }
  }

  void Grow() {
    while (out_.causes.size() < kMaxCauses) {
      const ScreenedEffect* best = BestPhysical(Current().effects);
      if (best == nullptr || best->log_evidence < threshold_nats_) break;
      std::vector<GapCause> causes = out_.causes;
      causes.push_back(Refined(Current(), *best));
      Report("with " + best->name, 0.3 + 0.1 * static_cast<double>(out_.causes.size()));
      out_.explained_nats += best->log_evidence;
      out_.causes = causes;
      if (fitter_.options().depth == GapOptions::Depth::kScreen) break;
      std::unique_ptr<ExtendedFit> next = TryFit(causes);
      if (!next) break;
      if (out_.final) before_.push_back(std::move(out_.final));
      out_.final = std::move(next);
      ReconsiderNoise();
    }
  }

  /// Selects and sizes noise effects again. They were estimated before the later causes were known,
  /// and so may have absorbed errors of these causes.
  void ReconsiderNoise() {
    std::vector<GapCause> causes = out_.causes;
    bool changed = false;
    for (std::size_t k = 0; k + 1 < causes.size(); ++k) {
      if (FindEffect(causes[k].effect)->fixed()) continue;
      const std::unique_ptr<ExtendedFit> others = TryFit(Without(k));
      const ScreenedEffect* best = others ? BestPhysical(others->effects) : nullptr;
      const ScreenedEffect* own = others ? Find(others->effects, causes[k].effect) : nullptr;
      if (best == nullptr || own == nullptr) continue;
      const bool another = best->log_evidence >= own->log_evidence + kReplacementLeadNats;
      const GapCause refined = Refined(*others, another ? *best : *own);
      const double moved = std::abs(refined.estimate[0] - causes[k].estimate[0]);
      if (!another && moved <= causes[k].sigma[0]) continue;
      causes[k] = refined;
      changed = true;
    }
    if (changed) Replace(causes);
  }

  std::vector<GapCause> Without(std::size_t k) const {
    std::vector<GapCause> others = out_.causes;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    return others;
  }

  /// Returns the flight adjusted with all causes but one; null if that fails.
  const ExtendedFit* FitWithout(std::size_t k) {
    const std::size_t n = out_.causes.size();
    if (n == 1) return out_.base.get();
    if (k + 1 == n && !revised_ && !before_.empty()) return before_.back().get();
    scratch_ = TryFit(Without(k));
    return scratch_.get();
  }

  /// Revises at most one earlier choice: each was made with fewer effects in the model than now.
  void Revise() {
    for (std::size_t k = 0; k + 1 < out_.causes.size(); ++k) {
      Report("without " + out_.causes[k].effect, 0.7);
      const ExtendedFit* others = FitWithout(k);
      if (others == nullptr) continue;
      const ScreenedEffect* best = BestPhysical(others->effects);
      if (best == nullptr) continue;
      const double own = FindEvidence(others->effects, out_.causes[k].effect);
      if (own < threshold_nats_ && best->log_evidence < threshold_nats_) {
        Replace(Without(k));
        return;
      }
      if (best->log_evidence < own + kReplacementLeadNats) {
        KeepRivals(k, *others);
        continue;
      }
      std::vector<GapCause> causes = Without(k);
      causes.push_back(Refined(*others, *best));
      Replace(causes);
      return;
    }
  }

  void Replace(const std::vector<GapCause>& causes) {
    std::unique_ptr<ExtendedFit> next = TryFit(causes);
    if (!next) return;
    out_.causes = causes;
    out_.final = std::move(next);
    revised_ = true;
    kept_.clear();
  }

  void KeepRivals(std::size_t k, const ExtendedFit& others) {
    kept_.emplace_back(k, others.effects);
  }

  void MakeAllHypotheses() {
    if (out_.causes.empty()) {
      out_.slots.push_back(MakeCompetingHypotheses("", out_.base->effects));
      return;
    }
    for (std::size_t k = 0; k < out_.causes.size(); ++k) {
      const auto kept =
          std::find_if(kept_.begin(), kept_.end(), [&](const auto& one) { return one.first == k; });
      if (kept != kept_.end()) {
        out_.slots.push_back(MakeCompetingHypotheses(out_.causes[k].effect, kept->second));
        continue;
      }
      const ExtendedFit* others = FitWithout(k);
      if (others == nullptr) others = out_.base.get();
      out_.slots.push_back(MakeCompetingHypotheses(out_.causes[k].effect, others->effects));
    }
  }

  const ExtendedModelFitter& fitter_;
  double threshold_nats_;
  SelectedModel out_;
  // Earlier fits, in order: with the first cause, with the first two causes, and so on.
  std::vector<std::unique_ptr<ExtendedFit>> before_;
  std::unique_ptr<ExtendedFit> scratch_;
  std::vector<std::pair<std::size_t, std::vector<ScreenedEffect>>> kept_;
  bool revised_ = false;
};

}  // namespace

SelectedModel SelectEffects(const ExtendedModelFitter& model_fitter,
                            std::unique_ptr<ExtendedFit> base, bool detected,
                            double threshold_nats) {
  return ForwardSelection(model_fitter, std::move(base), threshold_nats).Run(detected);
}

}  // namespace dn::internal
