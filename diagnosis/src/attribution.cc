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
  ForwardSelection(const Explainer& explainer, std::unique_ptr<ExplainedFlight> base,
                   double threshold_nats)
      : explainer_(explainer), threshold_nats_(threshold_nats) {
    out_.base = std::move(base);
  }

  Attribution Run(bool detected) {
    explainer_.JudgeProcesses(out_.base.get());
    out_.generic_nats = GenericEvidence(out_.base->effects);
    if (detected) {
      Grow();
      if (out_.causes.size() > 1) Revise();
    }
    MakeSlots();
    return std::move(out_);
  }

 private:
  const ExplainedFlight& Current() const { return out_.last(); }

  GapCause Refined(const ExplainedFlight& explained, ScreenedEffect effect) const {
    RefineTimes(explained.solution->network(), explained.solution->marginals(),
                explainer_.options().threads, &effect);
    return ToCause(effect);
  }

  void Report(const std::string& stage, double fraction) const {
    if (explainer_.options().progress) explainer_.options().progress(stage, fraction);
  }

  /// Adjusts the flight with these causes. Returns null and adds a note if it cannot be adjusted.
  std::unique_ptr<ExplainedFlight> TryExplain(const std::vector<GapCause>& causes) {
    try {
      auto explained = std::make_unique<ExplainedFlight>(explainer_.Explain(causes));
      explainer_.JudgeProcesses(explained.get());
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
    while (out_.causes.size() < kMostCauses) {
      const ScreenedEffect* best = BestPhysical(Current().effects);
      if (best == nullptr || best->log_evidence < threshold_nats_) break;
      std::vector<GapCause> causes = out_.causes;
      causes.push_back(Refined(Current(), *best));
      Report("with " + best->name, 0.3 + 0.1 * static_cast<double>(out_.causes.size()));
      out_.explained_nats += best->log_evidence;
      out_.causes = causes;
      if (explainer_.options().depth == GapOptions::Depth::kScreen) break;
      std::unique_ptr<ExplainedFlight> next = TryExplain(causes);
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
      const std::unique_ptr<ExplainedFlight> others = TryExplain(Without(k));
      const ScreenedEffect* best = others ? BestPhysical(others->effects) : nullptr;
      const ScreenedEffect* own = others ? Find(others->effects, causes[k].effect) : nullptr;
      if (best == nullptr || own == nullptr) continue;
      const bool another = best->log_evidence >= own->log_evidence + kSwapNats;
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
  const ExplainedFlight* ExplainedWithout(std::size_t k) {
    const std::size_t n = out_.causes.size();
    if (n == 1) return out_.base.get();
    if (k + 1 == n && !revised_ && !before_.empty()) return before_.back().get();
    scratch_ = TryExplain(Without(k));
    return scratch_.get();
  }

  /// Revises at most one earlier choice: each was made with fewer effects in the model than now.
  void Revise() {
    for (std::size_t k = 0; k + 1 < out_.causes.size(); ++k) {
      Report("without " + out_.causes[k].effect, 0.7);
      const ExplainedFlight* others = ExplainedWithout(k);
      if (others == nullptr) continue;
      const ScreenedEffect* best = BestPhysical(others->effects);
      if (best == nullptr) continue;
      const double own = EvidenceOf(others->effects, out_.causes[k].effect);
      if (own < threshold_nats_ && best->log_evidence < threshold_nats_) {
        Replace(Without(k));
        return;
      }
      if (best->log_evidence < own + kSwapNats) {
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
    std::unique_ptr<ExplainedFlight> next = TryExplain(causes);
    if (!next) return;
    out_.causes = causes;
    out_.final = std::move(next);
    revised_ = true;
    kept_.clear();
  }

  void KeepRivals(std::size_t k, const ExplainedFlight& others) {
    kept_.emplace_back(k, others.effects);
  }

  void MakeSlots() {
    if (out_.causes.empty()) {
      out_.slots.push_back(MakeSlot("", out_.base->effects));
      return;
    }
    for (std::size_t k = 0; k < out_.causes.size(); ++k) {
      const auto kept =
          std::find_if(kept_.begin(), kept_.end(), [&](const auto& one) { return one.first == k; });
      if (kept != kept_.end()) {
        out_.slots.push_back(MakeSlot(out_.causes[k].effect, kept->second));
        continue;
      }
      const ExplainedFlight* others = ExplainedWithout(k);
      if (others == nullptr) others = out_.base.get();
      out_.slots.push_back(MakeSlot(out_.causes[k].effect, others->effects));
    }
  }

  const Explainer& explainer_;
  double threshold_nats_;
  Attribution out_;
  // Models with the first causes; each has one cause more than the one before.
  std::vector<std::unique_ptr<ExplainedFlight>> before_;
  std::unique_ptr<ExplainedFlight> scratch_;
  std::vector<std::pair<std::size_t, std::vector<ScreenedEffect>>> kept_;
  bool revised_ = false;
};

}  // namespace

Attribution Attribute(const Explainer& explainer, std::unique_ptr<ExplainedFlight> base,
                      bool detected, double threshold_nats) {
  return ForwardSelection(explainer, std::move(base), threshold_nats).Run(detected);
}

}  // namespace dn::internal
