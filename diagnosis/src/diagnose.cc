#include <dn/diagnosis/adapt.h>
#include <dn/diagnosis/diagnose.h>
#include <dn/diagnosis/gap_output.h>
#include <dn/diagnosis/replicate_scenario.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/interrupted.h>
#include <dn/names.h>
#include <dn/sim/random.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "boresight_average.h"
#include "competing_hypotheses.h"
#include "decision.h"
#include "design_limits.h"
#include "fixed_trajectory_source.h"
#include "forward_selection.h"
#include "gap_source.h"
#include "lap_times.h"
#include "network_source.h"
#include "simulated_replicates.h"
#include "tie_breaker.h"
#include "unavailable.h"
#include "unmodelled.h"

namespace dn {
namespace {

using namespace diagnosis_internal;

// Fraction of its evidence that a large effect may lose to second-order terms.
constexpr double kSecondOrder = 0.05;
// Multiple of the typical size above which an effect is implausible, and the fraction of the named
// evidence at which a discrepancy makes it doubtful. The fraction is below 1 because the evidence
// of a discrepancy is reduced by its many components.
constexpr double kPlausibleSizes = 10.0, kDiscrepancyEvidenceShare = 0.9;
constexpr double kSignificantSigmas = 2.0;
// If the test of replicates against replicates has a p-value below this, they are not a valid
// reference.
constexpr double kUnequalReplicates = 1e-4;
constexpr int kSimulatedReplicates = 8;  // without and with the effects each

/// Tests whether the data of a source agree with its model, selects the effects that explain the
/// gap, and measures what they leave.
class Diagnosis {
 public:
  /// All arguments must outlive the object.
  Diagnosis(const Flight& flight, const GapOptions& options, GapSource* source)
      : flight_(flight), options_(options), source_(*source), watch_(&out_.timings_s) {
    out_.flight = flight.config.name;
    out_.trajectory_given = !source_.adjusts();
    out_.validity.alpha = options.alpha;
    out_.outside_prior = options.outside;
  }

  GapResult Run() {
    ShowProgress("adjusting", 0.0);
    std::unique_ptr<ExtendedFit> base = source_.Fit({});
    watch_.Lap("adjustment and screen");
    if (options_.depth == GapOptions::Depth::kLimits) return Limits(*base);
    ShowProgress("replicates", 0.15);
    before_ = source_.Compare(*base);
    watch_.Lap("twins");
    JudgeGap(*base);
    SelectEffects(std::move(base));
    watch_.Lap("attribution");
    if (selection_.final) {
      ShowProgress("replicates with the effects", 0.8);
      after_ = source_.Compare(*selection_.final);
      watch_.Lap("twins with the effects");
    }
    source_.ListPlaces(*selection_.base, before_, selection_.last(), &out_);
    CompareHypotheses(GapRemains() ? RestNats() : 0.0);
    FillCauses(selection_.base->effects, hypotheses_, NamedCauses(), &out_);
    SetLeftNats();
    MarkTolerances();
    FillVerdict();
    MeasureShrinkage();
    MeasureHeldOut();
    const Trajectory trajectory = source_.MakeTrajectory(selection_.last());
    if (options_.depth == GapOptions::Depth::kFull && source_.adjusts()) {
      ShowProgress("simulated replicates", 0.88);
      CompareSimulated(trajectory);
      watch_.Lap("simulated twins");
    }
    ShowProgress("limits", 0.94);
    FillDetectionLimits(*selection_.base, Threshold());
    BreakTies(trajectory);
    AverageOverHypotheses();
    AppendNotes(selection_.notes);
    AppendNotes(source_.Notes(*selection_.base));
    out_.verdict.text = VerdictSentence(out_);
    return Result(trajectory);
  }

 private:
  /// Sets the evidence that the effects outside the verdict have with its effects in the model.
  void SetLeftNats() {
    if (!selection_.final) return;
    for (GapCause& cause : out_.causes) {
      const HypothesisEvidence* left = FindByName(selection_.final->effects, cause.effect);
      if (left != nullptr) cause.left_nats = left->log_evidence;
    }
  }

  /// Compares the fixed causes with their priors.
  void MarkTolerances() {
    const UnmodelledPrior prior = MakeUnmodelledPrior(flight_.config);
    out_.with_tolerances = !prior.pure();
    for (GapCause& cause : out_.causes) {
      const EffectSpec* spec = FindEffect(cause.effect);
      if (spec == nullptr || !spec->fixed() || cause.estimate.size() == 0) continue;
      const double to_si = spec->components.front().to_si;
      cause.prior_sigmas =
          InPriorSigmas(prior, spec->id, to_si * cause.estimate, to_si * cause.sigma);
    }
  }

  /// Computes the detection limits from the geometry at the solution.
  GapResult Limits(const ExtendedFit& base) {
    FillDetectionLimits(base, kDesignThresholdNats);
    if (source_.adjusts()) out_.validity.observations = source_.observations(base);
    return WithLimits(flight_, std::move(out_));
  }

  void ShowProgress(const std::string& stage, double fraction) const {
    if (options_.interrupted && options_.interrupted()) throw Interrupted();
    if (options_.progress) options_.progress(stage, fraction);
  }

  double Threshold() const { return ThresholdNats(before_.test.evidence_95); }

  void AppendNotes(const std::vector<std::string>& notes) {
    out_.validity.notes.insert(out_.validity.notes.end(), notes.begin(), notes.end());
  }

  void JudgeGap(const ExtendedFit& base) {
    const GapMeasure measure = source_.Measure(base, before_);
    out_.p_value = measure.p_value;
    out_.detected = out_.p_value <= options_.alpha;
    out_.size = measure.size;
    out_.user_units = measure.user_units;
    out_.validity.observations = source_.observations(base);
    out_.validity.replicates = static_cast<int>(before_.replicates.all.size());
    out_.validity.tests = static_cast<int>(before_.statistics.size() + base.effects.size());
    out_.validity.aa_p_value = measure.replicate_consistency_p;
    if (out_.validity.aa_p_value >= kUnequalReplicates) return;
    out_.validity.notes.push_back(
        "replicates of the flight differ among themselves and are not a valid reference");
  }

  // ---- Which effects ----------------------------------------------------------------------------

  SelectionPolicy Policy() const {
    SelectionPolicy policy;
    policy.threshold_nats = Threshold();
    policy.most = kMaxCauses;
    policy.refits = !source_.adjusts() || options_.depth != GapOptions::Depth::kScreen;
    policy.resizes_noise = source_.adjusts();
    policy.next = BestPhysical;
    policy.refine = [this](const ExtendedFit& fit, const HypothesisEvidence& effect) {
      return source_.Refine(fit, effect);
    };
    policy.progress = [this](const std::string& stage, double fraction) {
      ShowProgress(stage, 0.3 + 0.4 * fraction);
    };
    return policy;
  }

  /// Selects no effect if no gap was detected.
  void SelectEffects(std::unique_ptr<ExtendedFit> base) {
    ForwardSelection selection(
        Policy(), [this](const auto& chosen) { return source_.Fit(chosen); }, std::move(base));
    if (out_.detected) {
      selection.Grow();
      selection.Revise();
    }
    alternatives_ = selection.Alternatives();
    selection_ = selection.Take();
  }

  /// Computes the probabilities of all hypotheses. `rest_nats` is the evidence of a significant
  /// rest, 0 without one.
  void CompareHypotheses(double rest_nats) {
    prior_ = {options_.outside, Threshold(), rest_nats};
    hypotheses_.clear();
    for (std::size_t k = 0; k < alternatives_.size(); ++k) {
      hypotheses_.push_back(
          MakeCompetingHypotheses(selection_.chosen[k].name, alternatives_[k], prior_));
    }
    if (hypotheses_.empty()) {
      hypotheses_.push_back(MakeCompetingHypotheses("", selection_.base->effects, prior_));
    }
  }

  double RestNats() const {
    return std::max(Threshold(), DiscrepancyEvidence(selection_.last().effects));
  }

  /// Returns the causes with their estimates of the last fit.
  std::vector<GapCause> NamedCauses() const {
    return ToCauses(selection_.final ? selection_.final->chosen : selection_.chosen);
  }

  // ---- Verdict ----------------------------------------------------------------------------------

  void FillVerdict() {
    if (out_.validity.aa_p_value < kUnequalReplicates) {
      out_.verdict.kind = GapVerdictKind::kUnavailable;
      return;
    }
    const std::vector<GapHeavyTails> heavy_tails = FindHeavyTails();
    std::vector<std::string> named;
    for (const HypothesisEvidence& effect : selection_.chosen) {
      if (!IsReplaced(heavy_tails, effect.name)) named.push_back(effect.name);
    }
    const Decision decision{out_.detected, DiscrepancyIsBetter(), GapRemains()};
    out_.verdict = Decide(decision, named, hypotheses_);
    out_.verdict.rest =
        decision.discrepancy_is_better ||
        (selection_.final && DiscrepancyEvidence(selection_.final->effects) > Threshold());
    if (!heavy_tails.empty()) TakeHeavyTails(heavy_tails);
    if (source_.adjusts()) out_.verdict.implausible = Implausible();
  }

  /// Returns the sensors whose selected outliers are the tails of their noise.
  std::vector<GapHeavyTails> FindHeavyTails() const {
    struct OfSensor {
      const char* name;
      EffectId outliers, scale;
    };
    constexpr OfSensor kSensors[] = {{"gnss", EffectId::kGnssOutliers, EffectId::kGnssNoiseScale},
                                     {"lidar", EffectId::kP2pOutliers, EffectId::kP2pNoiseScale}};
    std::vector<GapHeavyTails> found;
    for (const OfSensor& sensor : kSensors) {
      if (!Contains(selection_.chosen, sensor.outliers)) continue;
      const std::optional<NoiseShape> shape = source_.Shape(*selection_.base, sensor.outliers);
      if (!shape || shape->outlier_lead_nats > -kDiscrepancyLeadNats) continue;
      GapHeavyTails tails{sensor.name, shape->dof, shape->scale, -shape->outlier_lead_nats, {}};
      for (const EffectId effect : {sensor.outliers, sensor.scale}) {
        if (Contains(selection_.chosen, effect)) tails.replaced.push_back(EffectName(effect));
      }
      found.push_back(std::move(tails));
    }
    return found;
  }

  static bool IsReplaced(const std::vector<GapHeavyTails>& heavy_tails, const std::string& effect) {
    return std::any_of(heavy_tails.begin(), heavy_tails.end(),
                       [&](const auto& tails) { return HasName(tails.replaced, effect); });
  }

  /// No effect of the table is noise with heavy tails.
  void TakeHeavyTails(const std::vector<GapHeavyTails>& heavy_tails) {
    GapVerdict& verdict = out_.verdict;
    verdict.heavy_tails = heavy_tails;
    verdict.unknown = true;
    verdict.kind = verdict.effects.empty() ? GapVerdictKind::kUnknown : GapVerdictKind::kPartial;
    LowerReplaced();
  }

  /// Lowers the probabilities of effects that describe heavy tails worse.
  void LowerReplaced() {
    for (const GapHeavyTails& tails : out_.verdict.heavy_tails) {
      for (GapCause& cause : out_.causes) {
        if (HasName(tails.replaced, cause.effect))
          cause.posterior /= 1.0 + std::exp(tails.lead_nats);
      }
    }
  }

  /// Returns a named effect of implausible size, if there is one. An effect that is wrongly named
  /// for unmodelled physics can have an estimate of any size.
  std::optional<GapImplausible> Implausible() const {
    const HypothesisEvidence* generic = BestDiscrepancy(selection_.base->effects);
    if (generic == nullptr ||
        generic->log_evidence < kDiscrepancyEvidenceShare * selection_.explained_nats) {
      return std::nullopt;
    }
    for (const GapCause& cause : NamedCauses()) {
      const EffectSpec& spec = *FindEffect(cause.effect);
      if (!spec.fixed()) continue;
      for (Eigen::Index k = 0; k < cause.estimate.size(); ++k) {
        const double typical = spec.components[static_cast<std::size_t>(k)].typical;
        const double size = std::abs(cause.estimate[k]);
        if (size - kSignificantSigmas * cause.sigma[k] > kPlausibleSizes * typical) {
          return GapImplausible{cause.effect, size / typical, generic->name};
        }
      }
    }
    return std::nullopt;
  }

  /// Returns whether a discrepancy describes the data better than the named effects. A discrepancy
  /// of many components may fit the second-order terms of a large effect. These terms vanish once
  /// the flight is adjusted with the effect.
  bool DiscrepancyIsBetter() const {
    const double lead_nats =
        DiscrepancyEvidence(selection_.base->effects) - selection_.explained_nats;
    if (lead_nats <= kDiscrepancyLeadNats) return false;
    if (!source_.adjusts()) return true;
    if (selection_.final) return GapRemains();
    return lead_nats > kSecondOrder * selection_.explained_nats;
  }

  bool GapRemains() const {
    return selection_.final && source_.GapRemains(*selection_.final, after_, Threshold());
  }

  // ---- What the effects leave -------------------------------------------------------------------

  void MeasureShrinkage() {
    if (!selection_.final || !out_.detected || out_.verdict.effects.empty()) return;
    GapShrinkage shrinkage =
        source_.Shrinkage({*selection_.base, before_, *selection_.final, after_});
    shrinkage.before.p_value = out_.p_value;
    const HypothesisEvidence* rest = BestDiscrepancy(selection_.final->effects);
    if (rest != nullptr && rest->log_evidence > Threshold()) shrinkage.rest = ToDiscrepancy(*rest);
    out_.shrinkage = shrinkage;
  }

  /// Measures how much the causes improve the prediction of held-out data.
  void MeasureHeldOut() {
    if (!out_.shrinkage) return;
    ShowProgress("held-out data", 0.85);
    const std::optional<HeldOutGains> gains = source_.HeldOut(*selection_.base, *selection_.final);
    watch_.Lap("data held out");
    if (!gains) return;
    FillReachable(*gains, &*out_.shrinkage);
    for (std::size_t k = 0; k < selection_.chosen.size(); ++k) {
      for (GapCause& cause : out_.causes) {
        if (cause.effect == selection_.chosen[k].name) {
          cause.held_out_gain_nats = gains->cause_gains[k];
        }
      }
    }
  }

  /// Computes the reachable gain. The best of all further effects gains something on every flight,
  /// so its mean gain over replicates is subtracted.
  void FillReachable(const HeldOutGains& gains, GapShrinkage* shrinkage) const {
    double of_replicates = 0.0;
    for (const ResidualSummary& one : after_.replicates.all) {
      of_replicates +=
          std::max(0.0, one.log_evidence.size() > 0 ? one.log_evidence.maxCoeff() : 0.0);
    }
    of_replicates /= static_cast<double>(after_.replicates.all.size());
    const double left = std::max(0.0, gains.further_nats - of_replicates);
    const double gain = std::max(0.0, gains.gain_nats);
    shrinkage->held_out_gain_nats = gains.gain_nats;
    shrinkage->reachable_left_nats = left;
    if (gain + left > 0.0) shrinkage->share_of_reachable = gain / (gain + left);
  }

  /// Simulates replicates without and with the effects.
  void CompareSimulated(const Trajectory& trajectory) {
    const LinearReplicates linear =
        NameLinearReplicates(before_.statistics, before_.replicates, before_.test);
    const std::vector<NamedStatistics> without = SimulateWith({}, trajectory);
    out_.validity.simulated_replicates = static_cast<int>(without.size());
    out_.validity.full_against_linear_p =
        TestSimulatedAgainstLinear(without, linear, options_.seed);
    const std::vector<GapCause> named = VerdictCauses(out_);
    if (named.empty()) return;
    const std::vector<NamedStatistics> with = SimulateWith(named, trajectory);
    out_.validity.simulated_replicates += static_cast<int>(with.size());
    for (FingerprintValue& value : out_.fingerprint) {
      const std::optional<MeanAndSigma> of_replicates = ReplicateMeanAndSigma(with, value.name);
      if (!of_replicates) continue;
      value.simulated_mean = of_replicates->mean;
      value.simulated_sigma = of_replicates->sigma;
    }
    const NamedStatistics flight = Comparable(before_.statistics, before_.appearance.locations);
    out_.validity.like_replicates_p = TestAmongReplicates(flight, with, linear, options_.seed);
    if (out_.validity.like_replicates_p.value_or(1.0) < kUnlike) LowerToPartial();
  }

  /// Returns no statistics, and adds a note, if the simulator cannot fly the scenario.
  std::vector<NamedStatistics> SimulateWith(const std::vector<GapCause>& causes,
                                            const Trajectory& trajectory) {
    SimulatedReplicateOptions options;
    options.count = kSimulatedReplicates;
    options.seed = MixBits(options_.seed) + causes.size();
    options.threads = options_.threads;
    options.interrupted = options_.interrupted;
    try {
      const Scenario scenario =
          MakeReplicateScenario(flight_, trajectory, causes, source_.Boresight(selection_.last()));
      return SimulateReplicates(flight_, scenario, trajectory, options);
    } catch (const InvalidInput& error) {
      out_.validity.notes.push_back(std::string("no simulated replicates: ") + error.what());
    }
    return {};
  }

  /// Lowers the verdict to partial: replicates with the named effects do not reproduce the flight.
  void LowerToPartial() {
    GapVerdict& verdict = out_.verdict;
    if (verdict.kind == GapVerdictKind::kIdentified || verdict.kind == GapVerdictKind::kGroup) {
      verdict.kind = GapVerdictKind::kPartial;
      verdict.unknown = true;
      CompareHypotheses(RestNats());
      SetProbabilities(hypotheses_, &out_);
    }
  }

  // ---- The boresight over all hypotheses --------------------------------------------------------

  /// Averages the boresight over the named effects with their alternatives, or over all hypotheses
  /// without a named effect.
  void AverageOverHypotheses() {
    const bool named = !out_.verdict.effects.empty() && selection_.final;
    const ExtendedFit& fit = named ? *selection_.final : *selection_.base;
    if (!fit.boresight || out_.verdict.kind == GapVerdictKind::kUnavailable) return;
    const std::vector<CompetingHypotheses> none;
    out_.boresight_averaged = AverageBoresight(*fit.boresight, named ? hypotheses_ : none,
                                               MakeCompetingHypotheses("", fit.effects, prior_));
  }

  // ---- What remains undetectable ----------------------------------------------------------------

  void FillDetectionLimits(const ExtendedFit& base, double threshold_nats) {
    out_.could_still_hide = source_.Limits(base, threshold_nats);
    watch_.Lap("limits");
  }

  void BreakTies(const Trajectory& trajectory) {
    const std::vector<Tie> ties = FindTies(out_);
    if (options_.depth == GapOptions::Depth::kScreen || !source_.adjusts() || ties.empty()) return;
    ShowProgress("how to separate the causes", 0.97);
    std::vector<std::string> sentences;
    for (const Tie& tie : ties) {
      const std::string text = ProposeTieBreaker(
          flight_, trajectory, source_.Boresight(selection_.last()), tie, options_);
      if (!text.empty()) sentences.push_back(text);
    }
    out_.verdict.tie_breaker = fmt::format("{}", fmt::join(sentences, "; "));
    watch_.Lap("tie breaker");
  }

  GapResult Result(const Trajectory& trajectory) {
    GapResult result;
    result.adapted = Adapted(flight_, out_);
    result.trajectory = trajectory;
    result.boresight_rad = source_.Boresight(selection_.last());
    result.diagnosis = std::move(out_);
    return result;
  }

  const Flight& flight_;
  const GapOptions& options_;
  GapSource& source_;
  GapDiagnosis out_;
  LapTimes watch_;
  Comparison before_, after_;
  Selection selection_;
  // Evidence of all effects given all chosen ones but one, for each of them.
  std::vector<std::vector<HypothesisEvidence>> alternatives_;
  HypothesisPrior prior_;
  std::vector<CompetingHypotheses> hypotheses_;
};

GapResult DiagnoseAvailableData(const Flight& flight, const GapOptions& options) {
  const bool limits = options.depth == GapOptions::Depth::kLimits;
  if (limits && flight.config.imu && flight.config.gnss && HasPoses(flight)) {
    return DiagnoseDesignLimits(flight, options);
  }
  if (flight.imu && flight.gnss) {
    NetworkSource source(flight, options);
    return Diagnosis(flight, options, &source).Run();
  }
  FixedTrajectorySource source(flight, options);
  return Diagnosis(flight, options, &source).Run();
}

/// Turns a failed adjustment into the verdict `unavailable`.
GapResult DiagnoseOrRecordFailure(const Flight& flight, const GapOptions& options) {
  try {
    return DiagnoseAvailableData(flight, options);
  } catch (const InvalidConfig&) {
    throw;
  } catch (const InvalidInput& error) {
    return Unavailable(flight, options, error.what());
  } catch (const RankDeficient& error) {
    return Unavailable(flight, options, error.what());
  } catch (const NotConverged& error) {
    return Unavailable(flight, options, error.what());
  } catch (const std::bad_alloc&) {
    return Unavailable(
        flight, options,
        "its network is too large for the memory of this machine; diagnose a part of "
        "the flight (time_span_s), or fewer pairs (lidar.pairs)");
  }
}

void ExpectEffects(const std::vector<std::string>& names, const char* option) {
  for (const std::string& name : names) {
    if (FindEffect(name) == nullptr) {
      throw InvalidConfig(std::string("diagnosis: ") + option + " names '" + name +
                          "', which is not an effect of the table");
    }
  }
}

}  // namespace

void GapOptions::Validate() const {
  if (!(alpha > 0.0 && alpha < 1.0))
    throw InvalidConfig("diagnosis: alpha must lie between 0 and 1");
  if (!(outside >= 0.0 && outside < 1.0)) {
    throw InvalidConfig("diagnosis: outside must be at least 0 and below 1");
  }
  if (threads < 1) throw InvalidConfig("diagnosis: threads must be at least 1");
  ExpectEffects(effects, "effects");
  ExpectEffects(left_out, "left_out");
}

GapResult Diagnose(const Flight& flight, const GapOptions& options) {
  options.Validate();
  return DiagnoseOrRecordFailure(flight, options);
}

}  // namespace dn
