#include "explained_flight.h"

#include <dn/diagnosis/adapt.h>
#include <dn/effects/effect_table.h>
#include <dn/interrupted.h>
#include <dn/navigation/robust_scale.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "evidence_adjustment.h"
#include "median_sigmas.h"
#include "outlier_evidence.h"
#include "processes.h"

namespace dn::internal {
namespace {

// Fractions of good data above the outlier thresholds.
constexpr double kGoodPairsLost = 6.3e-5, kGoodEpochsLost = 6e-7;
// A process is evaluated exactly if the screen gives it at least this fraction of the best
// evidence.
constexpr double kWithinReach = 0.5;
constexpr double kWorthJudgingNats = 3.0;

bool IsProcess(const ScreenedEffect& effect) {
  return effect.physical() && EffectRow(*effect.id).process();
}

/// Increases the noise of a sensor by its outliers that are too short to be rejected.
void AddShortOutlierNoise(const Flight& flight, const std::vector<GapCause>& causes,
                          FlightConfig* config) {
  const auto times = [](const GapCause& cause, double sigma_m, double norm) {
    return std::sqrt(1.0 +
                     ShortOutlierVariance(cause.estimate[0], cause.estimate[1], sigma_m, norm));
  };
  for (const GapCause& cause : causes) {
    if (IsEffect(cause.effect, EffectId::kP2pOutliers)) {
      config->lidar->sigma_p_m *= times(cause, MedianPairSigma(flight), kOutlierPairNorm);
    } else if (IsEffect(cause.effect, EffectId::kGnssOutliers)) {
      const double sigma_m = std::cbrt(MedianGnssSigma(flight).prod());
      config->gnss->sigma_scale *= times(cause, sigma_m, kOutlierNorm);
    }
  }
}

}  // namespace

ExtendedModelFitter::ExtendedModelFitter(const Flight& flight, const GapOptions& options)
    : flight_(flight),
      options_(options),
      with_pairs_(flight.pairs.has_value() && !flight.pairs->pairs.empty()) {}

Adjustment ExtendedModelFitter::AdjustWith(const Flight& flight, long* gnss_left_out) const {
  AdjustOptions adjust;
  adjust.with_pairs = with_pairs_;
  adjust.threads = options_.threads;
  adjust.interrupted = options_.interrupted;
  EvidenceAdjustment evidence = AdjustForEvidence(flight, adjust);
  if (gnss_left_out != nullptr) *gnss_left_out = evidence.gnss_left_out;
  return std::move(evidence.adjustment);
}

ExtendedFit ExtendedModelFitter::Explain(const std::vector<GapCause>& causes) const {
  ExtendedFit out;
  out.causes = causes;
  out.flight = std::make_unique<Flight>(flight_);
  out.flight->config = Adapted(flight_, causes);
  AddShortOutlierNoise(flight_, causes, &out.flight->config);
  out.solution =
      std::make_unique<Solution>(AdjustWith(*out.flight, &out.gnss_left_out), options_.threads);
  LibraryOptions library{options_.effects, options_.left_out, options_.threads};
  for (const GapCause& cause : causes) library.left_out.push_back(cause.effect);
  out.screen =
      std::make_unique<Screen>(out.solution->network(), out.solution->marginals(), library);
  out.effects = out.screen->Effects();
  VarianceScreen variances =
      ScreenVariances(out.solution->network(), out.solution->marginals(), library);
  out.coloured_imu_nats = variances.coloured_imu;
  for (ScreenedEffect& effect : variances.effects) out.effects.push_back(std::move(effect));
  AddOutliers(&out);
  SortByEvidence(&out.effects);
  return out;
}

void ExtendedModelFitter::AddOutliers(ExtendedFit* explained) const {
  const auto add = [&](EffectId id, long found, long of_all, double usual,
                       const std::vector<double>& lengths_m) {
    const LibraryOptions wanted{options_.effects, options_.left_out, 1};
    const bool there =
        std::any_of(explained->causes.begin(), explained->causes.end(),
                    [&](const GapCause& cause) { return IsEffect(cause.effect, id); });
    if (there || of_all == 0 || !wanted.Wanted(id)) return;
    explained->effects.push_back(OutlierEffect(id, found, of_all, usual, lengths_m));
  };
  const Adjustment& adjustment = explained->solution->adjustment();
  const FlightNetwork& network = *adjustment.network;
  std::vector<double> pairs_m, positions_m;
  for (std::size_t k = 0; k < network.pairs().edges().size(); ++k) {
    if (network.net().factor(network.pairs().edges()[k].id).active) continue;
    pairs_m.push_back(network.pairs().Difference(k).norm());
  }
  add(EffectId::kP2pOutliers, adjustment.outliers,
      static_cast<long>(network.pairs().edges().size()), kGoodPairsLost, pairs_m);
  for (const GnssEdge& edge : network.gnss().edges()) {
    if (network.net().factor(edge.position).active) continue;
    const Eigen::Vector3d p_m = network.flight().gnss->epochs[edge.epoch].p_m;
    const MapPose pose = network.trajectory().NodePose(edge.node);
    const Eigen::Vector3d arm_b_m = network.net().Value(network.calibration().gnss_lever_arm());
    positions_m.push_back((pose.p_mb + pose.q_mb * arm_b_m - p_m).norm());
  }
  add(EffectId::kGnssOutliers, explained->gnss_left_out,
      static_cast<long>(network.gnss().edges().size()), kGoodEpochsLost, positions_m);
}

void ExtendedModelFitter::EvaluateProcesses(ExtendedFit* explained) const {
  if (explained->effects.empty()) return;
  const double best = explained->effects.front().log_evidence;
  for (ScreenedEffect& effect : explained->effects) {
    if (!IsProcess(effect) || effect.log_evidence < kWorthJudgingNats) continue;
    // Scaled noise also fits time-correlated errors, so any process may be the true cause.
    const bool with_scaled_noise = explained->effects.front().id == EffectId::kGnssNoiseScale;
    if (effect.log_evidence < kWithinReach * best && !with_scaled_noise) continue;
    if (options_.interrupted && options_.interrupted()) throw Interrupted();
    EvaluateProcess(explained->solution->network(), options_.threads, &effect);
  }
  SortByEvidence(&explained->effects);
  ScreenedEffect& likeliest = explained->effects.front();
  if (IsProcess(likeliest) && likeliest.log_evidence >= kWorthJudgingNats) {
    RefineProcess(explained->solution->network(), options_.threads, &likeliest);
  }
}

ReplicateTest ExtendedModelFitter::Test(const ExtendedFit& explained, int count,
                                        ResidualSummary* appearance, ReplicateSet* twins,
                                        std::vector<LocationStatistic>* statistics) const {
  const Solution& solution = *explained.solution;
  const Locations locations(solution.network(), solution.linearized(),
                            solution.trajectory().redundancy);
  ReplicateOptions options;
  options.count = count;
  options.seed = options_.seed;
  options.threads = options_.threads;
  options.interrupted = options_.interrupted;
  *twins = MakeReplicates(solution.marginals(), *explained.screen, locations, options);
  *appearance = Look(*explained.screen, locations, solution.linearized().residual(),
                     explained.screen->score().s);
  *statistics = locations.statistics();
  return CompareWithReplicates(*appearance, *twins);
}

}  // namespace dn::internal
