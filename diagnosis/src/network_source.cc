#include "network_source.h"

#include <dn/adjustment/result.h>
#include <dn/error.h>
#include <dn/imu/shaking.h>
#include <dn/quantile.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "boresight_scatter.h"
#include "decision.h"
#include "detection_limits.h"
#include "refine_times.h"
#include "shrinkage.h"

namespace dn::diagnosis_internal {
namespace {

constexpr int kFoldsFull = 6, kFoldsQuick = 3;  // number of tiles, and of outages
// Replicates contain neither raw inertial samples nor outliers. A p-value of these two below this
// level shows a gap on its own. Raw data alone with such a p-value are worth a note.
constexpr double kCertain = 1e-3;
constexpr double kTrajectoryStepS = 0.01;
constexpr long kLeastFlightRedundancy = 30;

const NetworkFit& AsNetworkFit(const ExtendedFit& fit) {
  return static_cast<const NetworkFit&>(fit);
}

std::vector<double> Over(const ReplicateSet& replicates, double ResidualSummary::*what) {
  std::vector<double> values;
  for (const ResidualSummary& one : replicates.all) values.push_back(one.*what);
  return values;
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

/// Returns the excess of a root mean square over that of the replicates; nullopt without it.
std::optional<double> RootExcess(const Comparison& compared, double ResidualSummary::*what) {
  const double value = compared.appearance.*what;
  if (!(value > 0.0)) return std::nullopt;
  const double usual = Mean(Over(compared.replicates, what));
  return std::sqrt(std::max(0.0, value * value - usual * usual));
}

/// Returns whether replicates lack the effect: they contain neither raw inertial samples nor
/// outliers.
bool OutsideReplicates(const EffectSpec& effect) {
  const bool inertial = effect.sensor == EffectSensor::kImu ||
                        effect.sensor == EffectSensor::kGyro ||
                        effect.sensor == EffectSensor::kAccel;
  return effect.kind == EffectKind::kOutliers || (effect.kind == EffectKind::kNoise && inertial);
}

/// Returns the largest evidence of inertial noise and outliers, which replicates do not contain.
double NatsOutsideReplicates(const NetworkFit& fit) {
  double nats = 0.0;
  for (const HypothesisEvidence& effect : fit.effects) {
    const bool outside = effect.physical() && OutsideReplicates(EffectRow(*effect.id));
    if (outside) nats = std::max(nats, effect.log_evidence);
  }
  return nats;
}

GapSize MeasureSize(const Comparison& compared) {
  const std::vector<double> of_replicates = Over(compared.replicates, &ResidualSummary::size_nats);
  const double usual = Mean(of_replicates);
  GapSize size;
  size.value = compared.appearance.size_nats - usual;
  size.null_low = Quantile(of_replicates, 0.025) - usual;
  size.null_high = Quantile(of_replicates, 0.975) - usual;
  size.upper_limit_95 = std::max(0.0, size.value - (Quantile(of_replicates, 0.05) - usual));
  return size;
}

GapState State(const NetworkFit& fit, const Comparison& compared) {
  GapState state;
  state.p_value = compared.test.p_value;
  state.size_nats_per_obs = MeasureSize(compared).value;
  if (compared.appearance.pair_rms_m > 0.0) state.p2p_m = compared.appearance.pair_rms_m;
  if (compared.appearance.gnss_rms_m > 0.0) state.gnss_m = compared.appearance.gnss_rms_m;
  if (!fit.with_boresight()) return state;
  const BoresightResult boresight = fit.solution->Boresight();
  state.boresight_rad = boresight.angles_rad;
  state.boresight_sigma_rad = boresight.sigma_rad();
  return state;
}

/// Returns the residuals of all position or pair factors, also of rejected ones, in sigmas of their
/// expectation.
std::vector<Eigen::Vector3d> SensorResiduals(const NetworkFit& fit,
                                             const std::vector<FactorId>& factors) {
  constexpr double kLeastRedundancy = 0.05;
  const Network& net = fit.solution->network().net();
  const LinearizedNetwork& linearized = fit.solution->linearized();
  std::vector<Eigen::Vector3d> residuals;
  for (const FactorId id : factors) {
    const FactorRecord& record = net.factor(id);
    if (record.factor->residual_size() != 3) continue;
    std::vector<const double*> x;
    for (const BlockId block : record.blocks) x.push_back(net.block(block).value.get());
    Eigen::Vector3d residual;
    if (!EvaluateStored(*record.factor, x.data(), residual.data(), nullptr)) continue;
    if (const auto rows = linearized.FindRows(id)) {
      const auto redundancy = fit.solution->trajectory().redundancy.segment<3>(rows->first);
      residual.array() /= redundancy.array().max(kLeastRedundancy).sqrt();
    }
    residuals.push_back(residual);
  }
  return residuals;
}

}  // namespace

Comparison CompareNetwork(const NetworkFit& fit, const ReplicateOptions& options) {
  const Solution& solution = *fit.solution;
  const Locations locations(solution.network(), solution.linearized(),
                            solution.trajectory().redundancy);
  Comparison out;
  out.replicates = MakeReplicates(solution.marginals(), *fit.screen, locations, options);
  out.appearance = SummariseResiduals(*fit.screen, locations, solution.linearized().residual(),
                                      fit.screen->score().s);
  out.statistics = locations.statistics();
  out.test = CompareWithReplicates(out.appearance, out.replicates);
  return out;
}

NetworkSource::NetworkSource(const Flight& flight, const GapOptions& options)
    : options_(options), fitter_(flight, options) {}

std::unique_ptr<ExtendedFit> NetworkSource::Fit(const std::vector<HypothesisEvidence>& chosen) {
  auto fit = std::make_unique<NetworkFit>(fitter_.Fit(chosen));
  if (options_.depth == GapOptions::Depth::kLimits) return fit;
  const long redundancy = fit->solution->trajectory().figures.redundancy;
  if (chosen.empty() && redundancy < kLeastFlightRedundancy) {
    throw InvalidInput(
        "the redundancy of the measurements is too low to test the model; fly longer");
  }
  fitter_.EvaluateProcesses(fit.get());
  return fit;
}

HypothesisEvidence NetworkSource::Refine(const ExtendedFit& fit, HypothesisEvidence effect) const {
  const Solution& solution = *AsNetworkFit(fit).solution;
  RefineTimes(solution.network(), solution.marginals(), options_.threads, &effect);
  return effect;
}

Comparison NetworkSource::Compare(const ExtendedFit& fit) const {
  ReplicateOptions options;
  options.count = NumReplicates(options_.depth);
  options.seed = options_.seed;
  options.threads = options_.threads;
  options.interrupted = options_.interrupted;
  return CompareNetwork(AsNetworkFit(fit), options);
}

long NetworkSource::observations(const ExtendedFit& fit) const {
  return AsNetworkFit(fit).solution->linearized().rows();
}

GapMeasure NetworkSource::Measure(const ExtendedFit& base, const Comparison& before) const {
  const NetworkFit& fit = AsNetworkFit(base);
  GapMeasure measure;
  const double outside = std::exp(-NatsOutsideReplicates(fit));
  measure.p_value =
      outside < kCertain ? std::min(outside, before.test.p_value) : before.test.p_value;
  measure.size = MeasureSize(before);
  measure.user_units.p2p_excess_m = RootExcess(before, &ResidualSummary::pair_rms_m);
  measure.user_units.gnss_excess_m = RootExcess(before, &ResidualSummary::gnss_rms_m);
  measure.user_units.boresight_inconsistency_rad =
      BoresightScatter(fit.solution->network(), options_.threads);
  measure.replicate_consistency_p = TestReplicateConsistency(before.replicates);
  return measure;
}

bool NetworkSource::GapRemains(const ExtendedFit& final, const Comparison& after,
                               double threshold_nats) const {
  const bool unexplained = std::any_of(
      final.effects.begin(), final.effects.end(), [&](const HypothesisEvidence& effect) {
        return !effect.physical() && effect.log_evidence > threshold_nats;
      });
  return unexplained || after.test.p_value <= options_.alpha;
}

GapShrinkage NetworkSource::Shrinkage(const BeforeAndAfter& fits) const {
  const NetworkFit &base = AsNetworkFit(fits.base), &final = AsNetworkFit(fits.final);
  GapShrinkage shrinkage = OmnibusShrinkage({fits.before.test, NatsOutsideReplicates(base)},
                                            {fits.after.test, NatsOutsideReplicates(final)});
  shrinkage.before = State(base, fits.before);
  shrinkage.after = State(final, fits.after);
  return shrinkage;
}

std::optional<HeldOutGains> NetworkSource::HeldOut(const ExtendedFit& base,
                                                   const ExtendedFit& final) const {
  HeldOutOptions options;
  options.num_per_kind = options_.depth == GapOptions::Depth::kFull ? kFoldsFull : kFoldsQuick;
  options.threads = options_.threads;
  options.interrupted = options_.interrupted;
  const HeldOutGains gains = MeasureHeldOut(AsNetworkFit(base), AsNetworkFit(final), options);
  return gains.folds > 0 ? std::optional(gains) : std::nullopt;
}

void NetworkSource::ListPlaces(const ExtendedFit& /*base*/, const Comparison& before,
                               const ExtendedFit& /*last*/, GapDiagnosis* diagnosis) const {
  FillFingerprint(before, kMaxStatistics, diagnosis);
  AppendPlaces(before, options_.alpha, diagnosis);
}

std::vector<std::string> NetworkSource::Notes(const ExtendedFit& base) const {
  const NetworkFit& fit = AsNetworkFit(base);
  if (fit.raw_only_nats <= -std::log(kCertain)) return {};
  const std::optional<Shaking> shaking = FindShaking(*fit.flight->imu);
  if (!shaking || shaking->calm()) return {};
  return {"the inertial record shakes: " + Describe(*shaking) +
          "; the residuals show no effect on the result"};
}

std::optional<NoiseShape> NetworkSource::Shape(const ExtendedFit& base, EffectId outliers) const {
  constexpr std::size_t kFewest = 50;
  const NetworkFit& fit = AsNetworkFit(base);
  const FlightNetwork& network = fit.solution->network();
  std::vector<FactorId> factors;
  if (outliers == EffectId::kGnssOutliers) {
    for (const GnssEdge& edge : network.gnss().edges()) factors.push_back(edge.position);
  } else {
    for (const PairEdge& edge : network.pairs().edges()) factors.push_back(edge.id);
  }
  const std::vector<Eigen::Vector3d> residuals = SensorResiduals(fit, factors);
  if (residuals.size() < kFewest) return std::nullopt;
  return CompareNoiseShapes(residuals);
}

std::vector<DetectionLimit> NetworkSource::Limits(const ExtendedFit& base,
                                                  double threshold_nats) const {
  return ComputeDetectionLimits(*AsNetworkFit(base).screen, threshold_nats, options_.seed);
}

Trajectory NetworkSource::MakeTrajectory(const ExtendedFit& fit) const {
  return Trajectory(DenseTrajectory(AsNetworkFit(fit).solution->network(), kTrajectoryStepS));
}

Eigen::Vector3d NetworkSource::Boresight(const ExtendedFit& fit) const {
  const NetworkFit& own = AsNetworkFit(fit);
  return own.with_boresight() ? own.solution->Boresight().angles_rad
                              : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

}  // namespace dn::diagnosis_internal
