#include <dn/adjustment/result.h>
#include <dn/diagnosis/adapt.h>
#include <dn/diagnosis/diagnose.h>
#include <dn/diagnosis/report.h>
#include <dn/diagnosis/twin.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/interrupted.h>
#include <dn/quantile.h>
#include <dn/rotation.h>
#include <dn/sim/random.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "attribution.h"
#include "boresight_scatter.h"
#include "decision.h"
#include "design_limits.h"
#include "diagnose_gauss_helmert.h"
#include "explained_flight.h"
#include "full_twins.h"
#include "held_out.h"
#include "hidden_effects.h"
#include "lap_times.h"
#include "shrinkage.h"
#include "slots.h"
#include "tie_breaker.h"
#include "unavailable.h"

namespace dn {
namespace {

using namespace internal;

constexpr int kFoldsFull = 6, kFoldsQuick = 3;  // number of tiles, and of outages
// Fraction of its evidence that a large effect may lose to second-order terms.
constexpr double kSecondOrder = 0.05;
// Multiple of the typical size above which an effect is implausible, and the fraction of the named
// evidence at which a discrepancy makes it doubtful. The fraction is below 1 because the evidence
// of a discrepancy is reduced by its many components.
constexpr double kPlausibleSizes = 10.0, kRivalEvidenceShare = 0.9;
constexpr double kSignificantSigmas = 2.0;
// Replicates contain neither high-band inertial noise nor outliers. A p-value of these two below
// this level shows a gap on its own.
constexpr double kCertain = 1e-3;
// If the test of replicates against replicates has a p-value below this, they are not a valid
// reference.
constexpr double kUnequalReplicates = 1e-4;
constexpr double kTrajectoryStepS = 0.01;
constexpr int kSimulatedReplicates = 8;  // without and with the effects each
// If the p-value of the flight among its simulated replicates is below this, they do not reproduce
// the flight.
constexpr double kUnlike = 0.01;
constexpr long kLeastFlightRedundancy = 30;

std::vector<double> Over(const ReplicateSet& twins, double ResidualSummary::*what) {
  std::vector<double> values;
  for (const ResidualSummary& twin : twins.all) values.push_back(twin.*what);
  return values;
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

double RootExcess(double value, const std::vector<double>& of_replicates) {
  const double usual = Mean(of_replicates);
  return std::sqrt(std::max(0.0, value * value - usual * usual));
}

/// A flight compared with its replicates.
struct Compared {
  ResidualSummary appearance;
  ReplicateSet twins;
  std::vector<LocationStatistic> statistics;
  ReplicateTest test;
};

class Diagnosis {
 public:
  Diagnosis(const Flight& flight, const GapOptions& options)
      : flight_(flight), options_(options), fitter_(flight, options), watch_(&out_.timings_s) {
    out_.flight = flight.config.name;
    out_.validity.alpha = options.alpha;
  }

  GapResult Run() {
    Report("adjusting", 0.0);
    auto base = std::make_unique<ExtendedFit>(fitter_.Explain({}));
    watch_.Lap("adjustment and screen");
    if (options_.depth == GapOptions::Depth::kLimits) return Limits(*base);
    if (base->solution->trajectory().figures.redundancy < kLeastFlightRedundancy) {
      return Unavailable(flight_, options_,
                         "the redundancy of the measurements is too low to test the model; fly "
                         "longer");
    }
    Report("replicates", 0.15);
    before_ = Compare(*base);
    watch_.Lap("twins");
    JudgeGap(*base);
    const SelectedModel attribution =
        SelectEffects(fitter_, std::move(base), out_.detected, Threshold());
    watch_.Lap("attribution");
    if (attribution.final) {
      Report("replicates with the effects", 0.8);
      after_ = Compare(*attribution.final);
      watch_.Lap("twins with the effects");
    }
    FillCauses(attribution.base->effects, attribution.slots, NamedCauses(attribution), &out_);
    FillVerdict(attribution);
    if (attribution.final) {
      MeasureShrinkage(attribution);
      Report("held-out data", 0.85);
      MeasureHeldOut(attribution);
      watch_.Lap("data held out");
    }
    const Trajectory trajectory(
        DenseTrajectory(attribution.last().solution->network(), kTrajectoryStepS));
    if (options_.depth == GapOptions::Depth::kFull) {
      Report("simulated replicates", 0.88);
      CompareSimulated(attribution, trajectory);
      watch_.Lap("simulated twins");
    }
    Report("limits", 0.94);
    out_.could_still_hide =
        ComputeDetectionLimits(*attribution.base->screen, Threshold(), options_.seed);
    watch_.Lap("limits");
    BreakTies(attribution, trajectory);
    for (const std::string& note : attribution.notes) out_.validity.notes.push_back(note);
    out_.verdict.text = VerdictSentence(out_);
    return Result(attribution, trajectory);
  }

  /// Computes the detection limits from the geometry at the solution.
  GapResult Limits(const ExtendedFit& base) {
    out_.could_still_hide =
        ComputeDetectionLimits(*base.screen, kDesignThresholdNats, options_.seed);
    out_.validity.observations = base.solution->linearized().rows();
    watch_.Lap("limits");
    return WithLimits(flight_, std::move(out_));
  }

 private:
  void Report(const std::string& stage, double fraction) const {
    if (options_.interrupted && options_.interrupted()) throw Interrupted();
    if (options_.progress) options_.progress(stage, fraction);
  }

  Compared Compare(const ExtendedFit& explained) const {
    Compared out;
    out.test = fitter_.Test(explained, NumReplicates(options_.depth), &out.appearance, &out.twins,
                            &out.statistics);
    return out;
  }

  double Threshold() const { return ThresholdNats(before_.test.evidence_95); }

  /// Returns whether replicates lack the effect: they contain neither raw inertial samples nor
  /// outliers.
  static bool OutsideReplicates(const EffectSpec& effect) {
    const bool inertial = effect.sensor == EffectSensor::kImu ||
                          effect.sensor == EffectSensor::kGyro ||
                          effect.sensor == EffectSensor::kAccel;
    return effect.kind == EffectKind::kOutliers || (effect.kind == EffectKind::kNoise && inertial);
  }

  /// Returns the largest evidence of raw inertial noise and outliers, which replicates do not
  /// contain.
  static double NatsOutsideReplicates(const ExtendedFit& explained) {
    double nats = std::max(0.0, explained.coloured_imu_nats);
    for (const ScreenedEffect& effect : explained.effects) {
      const bool outside = effect.physical() && OutsideReplicates(EffectRow(*effect.id));
      if (outside) nats = std::max(nats, effect.log_evidence);
    }
    return nats;
  }

  void JudgeGap(const ExtendedFit& base) {
    const double outside = std::exp(-NatsOutsideReplicates(base));
    out_.p_value =
        outside < kCertain ? std::min(outside, before_.test.p_value) : before_.test.p_value;
    out_.detected = out_.p_value <= options_.alpha;
    FillSize();
    FillWhere(base);
    FillUserUnits();
    out_.user_units.boresight_inconsistency_rad =
        BoresightScatter(base.solution->network(), options_.threads);
    out_.validity.observations = base.solution->linearized().rows();
    out_.validity.twins = static_cast<int>(before_.twins.all.size());
    out_.validity.tests = static_cast<int>(before_.statistics.size() + base.effects.size());
    CheckReplicates();
  }

  void CheckReplicates() {
    out_.validity.aa_p_value = TestReplicateConsistency(before_.twins);
    if (out_.validity.aa_p_value >= kUnequalReplicates) return;
    out_.validity.notes.push_back(
        "replicates of the flight differ among themselves and are not a valid reference");
  }

  void FillSize() {
    const std::vector<double> of_replicates = Over(before_.twins, &ResidualSummary::size_nats);
    const double usual = Mean(of_replicates);
    out_.size.value = before_.appearance.size_nats - usual;
    out_.size.null_low = Quantile(of_replicates, 0.025) - usual;
    out_.size.null_high = Quantile(of_replicates, 0.975) - usual;
    out_.size.upper_limit_95 =
        std::max(0.0, out_.size.value - (Quantile(of_replicates, 0.05) - usual));
  }

  void FillUserUnits() {
    if (before_.appearance.pair_rms_m > 0.0) {
      out_.user_units.p2p_excess_m = RootExcess(before_.appearance.pair_rms_m,
                                                Over(before_.twins, &ResidualSummary::pair_rms_m));
    }
    if (before_.appearance.gnss_rms_m > 0.0) {
      out_.user_units.gnss_excess_m = RootExcess(before_.appearance.gnss_rms_m,
                                                 Over(before_.twins, &ResidualSummary::gnss_rms_m));
    }
  }

  void FillWhere(const ExtendedFit& base) {
    const ReplicateTest& test = before_.test;
    if (base.coloured_imu_nats > -std::log(kCertain)) {
      out_.where.push_back({"imu", "raw data, highest octaves", "the whole flight",
                            base.coloured_imu_nats, std::exp(-base.coloured_imu_nats)});
    }
    for (const Eigen::Index k : test.LargestFirst()) {
      const LocationStatistic& at = before_.statistics[static_cast<std::size_t>(k)];
      if (out_.fingerprint.size() < kMaxStatistics) {
        out_.fingerprint.push_back({StatisticName(at), before_.appearance.locations[k],
                                    test.mean[k], test.sigma[k], std::nullopt, std::nullopt});
      }
      if (out_.where.size() >= kMaxPlaces || test.p_adjusted[k] > options_.alpha) continue;
      out_.where.push_back({at.sensor, at.quantity,
                            at.location.empty() ? "the whole flight" : at.location, test.z[k],
                            test.p_adjusted[k]});
    }
  }

  std::vector<GapCause> NamedCauses(const SelectedModel& attribution) const {
    std::vector<GapCause> named = attribution.causes;
    if (!attribution.final) return named;
    for (GapCause& cause : named) TakeEstimate(*attribution.final, &cause);
    return named;
  }

  /// Takes the values of a fixed effect from the adjustment that estimates it.
  static void TakeEstimate(const ExtendedFit& final, GapCause* cause) {
    for (const UnknownEstimate& unknown : final.solution->Unknowns()) {
      if (unknown.name != cause->effect) continue;
      const auto n = static_cast<Eigen::Index>(unknown.value.size());
      cause->estimate = Eigen::VectorXd::Map(unknown.value.data(), n);
      cause->sigma = Eigen::VectorXd::Map(unknown.sigma.data(), n);
    }
  }

  void FillVerdict(const SelectedModel& attribution) {
    if (out_.validity.aa_p_value < kUnequalReplicates) {
      out_.verdict.kind = GapVerdictKind::kUnavailable;
      return;
    }
    std::vector<std::string> named;
    for (const GapCause& cause : attribution.causes) named.push_back(cause.effect);
    const Decision decision{out_.detected, DiscrepancyIsBetter(attribution),
                            GapRemains(attribution)};
    out_.verdict = Decide(decision, named, attribution.slots);
    out_.verdict.implausible = Implausible(attribution);
    ScaleToObservedRates(out_.verdict, &out_.causes);
  }

  /// Returns a named effect of implausible size, if there is one. An effect that is wrongly named
  /// for unmodelled physics can have an estimate of any size.
  std::optional<GapImplausible> Implausible(const SelectedModel& attribution) const {
    const ScreenedEffect* generic = BestDiscrepancy(attribution.base->effects);
    if (generic == nullptr ||
        generic->log_evidence < kRivalEvidenceShare * attribution.explained_nats) {
      return std::nullopt;
    }
    for (const GapCause& cause : NamedCauses(attribution)) {
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
  bool DiscrepancyIsBetter(const SelectedModel& attribution) const {
    const double margin = std::max(kDiscrepancyLeadNats, kSecondOrder * attribution.explained_nats);
    if (attribution.discrepancy_nats <= attribution.explained_nats + kDiscrepancyLeadNats)
      return false;
    if (attribution.final) return GapRemains(attribution);
    return attribution.discrepancy_nats > attribution.explained_nats + margin;
  }

  bool GapRemains(const SelectedModel& attribution) const {
    if (!attribution.final) return false;
    for (const ScreenedEffect& effect : attribution.final->effects) {
      if (!effect.physical() && effect.log_evidence > Threshold()) return true;
    }
    return after_.test.p_value <= options_.alpha;
  }

  void MeasureShrinkage(const SelectedModel& attribution) {
    if (!out_.detected || out_.verdict.effects.empty()) return;
    GapShrinkage shrinkage =
        OmnibusShrinkage({before_.test, NatsOutsideReplicates(*attribution.base)},
                         {after_.test, NatsOutsideReplicates(*attribution.final)});
    shrinkage.before.p_value = out_.p_value;
    shrinkage.before.size_nats_per_obs = out_.size.value;
    shrinkage.after.p_value = after_.test.p_value;
    shrinkage.after.size_nats_per_obs =
        after_.appearance.size_nats - Mean(Over(after_.twins, &ResidualSummary::size_nats));
    FillState(*attribution.base, before_, &shrinkage.before);
    FillState(*attribution.final, after_, &shrinkage.after);
    out_.shrinkage = shrinkage;
  }

  /// Measures how much the causes improve the prediction of held-out data.
  void MeasureHeldOut(const SelectedModel& attribution) {
    if (!out_.shrinkage) return;
    HeldOutOptions options;
    options.num_per_kind = options_.depth == GapOptions::Depth::kFull ? kFoldsFull : kFoldsQuick;
    options.threads = options_.threads;
    options.interrupted = options_.interrupted;
    const HeldOutGains gains =
        internal::MeasureHeldOut(*attribution.base, *attribution.final, options);
    if (gains.folds == 0) return;
    FillReachable(gains, &*out_.shrinkage);
    for (std::size_t k = 0; k < attribution.causes.size(); ++k) {
      for (GapCause& cause : out_.causes) {
        if (cause.effect == attribution.causes[k].effect) {
          cause.held_out_gain_nats = gains.cause_gains[k];
        }
      }
    }
  }

  /// Computes the reachable gain. The best of all further effects gains something on every flight,
  /// so its mean gain over replicates is subtracted.
  void FillReachable(const HeldOutGains& gains, GapShrinkage* shrinkage) const {
    double of_replicates = 0.0;
    for (const ResidualSummary& twin : after_.twins.all) {
      of_replicates +=
          std::max(0.0, twin.log_evidence.size() > 0 ? twin.log_evidence.maxCoeff() : 0.0);
    }
    of_replicates /= static_cast<double>(after_.twins.all.size());
    const double left = std::max(0.0, gains.further_nats - of_replicates);
    const double gain = std::max(0.0, gains.gain_nats);
    shrinkage->held_out_gain_nats = gains.gain_nats;
    shrinkage->reachable_left_nats = left;
    if (gain + left > 0.0) shrinkage->share_of_reachable = gain / (gain + left);
  }

  static void FillState(const ExtendedFit& explained, const Compared& compared, GapState* state) {
    if (compared.appearance.pair_rms_m > 0.0) state->p2p_m = compared.appearance.pair_rms_m;
    if (compared.appearance.gnss_rms_m > 0.0) state->gnss_m = compared.appearance.gnss_rms_m;
    const Solution& solution = *explained.solution;
    if (solution.linearized().FirstColumn(solution.network().boresight.id) < 0) return;
    const BoresightResult boresight = solution.Boresight();
    state->boresight_rad = boresight.angles_rad;
    state->boresight_sigma_rad = boresight.sigma_rad();
  }

  /// Simulates replicates without and with the effects.
  void CompareSimulated(const SelectedModel& attribution, const Trajectory& trajectory) {
    const ExtendedFit& last = attribution.last();
    const LinearReplicates linear =
        NameLinearReplicates(before_.statistics, before_.twins, before_.test);
    const std::vector<NamedStatistics> without = SimulateWith({}, last, trajectory);
    out_.validity.full_twins = static_cast<int>(without.size());
    out_.validity.full_against_linear_p =
        TestSimulatedAgainstLinear(without, linear, options_.seed);
    const std::vector<GapCause> named = VerdictCauses(out_);
    if (named.empty()) return;
    const std::vector<NamedStatistics> with = SimulateWith(named, last, trajectory);
    out_.validity.full_twins += static_cast<int>(with.size());
    for (FingerprintValue& value : out_.fingerprint) {
      const std::optional<MeanAndSigma> of_replicates = ReplicateMeanAndSigma(with, value.name);
      if (!of_replicates) continue;
      value.twin_mean = of_replicates->mean;
      value.twin_sigma = of_replicates->sigma;
    }
    const NamedStatistics flight = Comparable(before_.statistics, before_.appearance.locations);
    out_.validity.like_twins_p = TestAmongReplicates(flight, with, linear, options_.seed);
    if (out_.validity.like_twins_p.value_or(1.0) < kUnlike) LowerToPartial();
  }

  /// Returns no statistics, and adds a note, if the simulator cannot fly the scenario.
  std::vector<NamedStatistics> SimulateWith(const std::vector<GapCause>& causes,
                                            const ExtendedFit& last, const Trajectory& trajectory) {
    SimulatedReplicateOptions options;
    options.count = kSimulatedReplicates;
    options.seed = MixBits(options_.seed) + causes.size();
    options.threads = options_.threads;
    options.interrupted = options_.interrupted;
    try {
      const Scenario scenario =
          MakeReplicateScenario(flight_, trajectory, causes, TotalBoresight(last));
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
    }
  }

  void BreakTies(const SelectedModel& attribution, const Trajectory& trajectory) {
    const std::vector<Tie> ties = FindTies(out_);
    if (options_.depth == GapOptions::Depth::kScreen || ties.empty()) return;
    Report("how to separate the causes", 0.97);
    const ExtendedFit& last = attribution.last();
    std::vector<std::string> sentences;
    for (const Tie& tie : ties) {
      const std::string text =
          ProposeTieBreaker(flight_, trajectory, TotalBoresight(last), tie, options_);
      if (!text.empty()) sentences.push_back(text);
    }
    out_.verdict.tie_breaker = fmt::format("{}", fmt::join(sentences, "; "));
    watch_.Lap("tie breaker");
  }

  static Eigen::Vector3d TotalBoresight(const ExtendedFit& explained) {
    const Solution& solution = *explained.solution;
    if (solution.linearized().FirstColumn(solution.network().boresight.id) < 0) {
      return Eigen::Vector3d::Zero();
    }
    return solution.Boresight().angles_rad;
  }

  GapResult Result(const SelectedModel& attribution, const Trajectory& trajectory) {
    GapResult result;
    const ExtendedFit& last = attribution.last();
    result.adapted = Adapted(flight_, out_);
    result.trajectory = trajectory;
    result.boresight_rad = TotalBoresight(last);
    result.diagnosis = std::move(out_);
    return result;
  }

  const Flight& flight_;
  const GapOptions& options_;
  ExtendedModelFitter fitter_;
  GapDiagnosis out_;
  LapTimes watch_;
  Compared before_, after_;
};

GapResult DiagnoseAvailableData(const Flight& flight, const GapOptions& options) {
  const bool limits = options.depth == GapOptions::Depth::kLimits;
  if (limits && flight.config.imu && flight.config.gnss && HasPoses(flight)) {
    return DiagnoseDesignLimits(flight, options);
  }
  if (!flight.imu || !flight.gnss) return DiagnoseGaussHelmert(flight, options);
  return Diagnosis(flight, options).Run();
}

/// Turns a failed adjustment into the verdict `unavailable`.
GapResult DiagnoseOrReportFailure(const Flight& flight, const GapOptions& options) {
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
  if (threads < 1) throw InvalidConfig("diagnosis: threads must be at least 1");
  ExpectEffects(effects, "effects");
  ExpectEffects(left_out, "left_out");
}

GapResult Diagnose(const Flight& flight, const GapOptions& options) {
  options.Validate();
  return DiagnoseOrReportFailure(flight, options);
}

}  // namespace dn
