#include "network_fit.h"

#include <dn/diagnosis/adapt.h>
#include <dn/effects/effect_table.h>
#include <dn/interrupted.h>
#include <dn/navigation/robust_scale.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "boresight_average.h"
#include "evidence_adjustment.h"
#include "median_sigmas.h"
#include "outlier_evidence.h"
#include "processes.h"
#include "variances.h"

namespace dn::diagnosis_internal {
namespace {

// Fractions of good data above the outlier thresholds.
constexpr double kGoodPairsLost = 6.3e-5, kGoodEpochsLost = 6e-7;
// A process is evaluated exactly if the screen gives it at least this fraction of the best
// evidence.
constexpr double kWithinReach = 0.5;
constexpr double kWorthJudgingNats = 3.0;

bool IsProcess(const HypothesisEvidence& effect) {
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

/// Takes the values of fixed effects from the unknowns of the adjustment that estimates them.
void TakeEstimates(const std::vector<UnknownEstimate>& unknowns,
                   std::vector<HypothesisEvidence>* effects) {
  for (HypothesisEvidence& effect : *effects) {
    const auto at = std::find_if(unknowns.begin(), unknowns.end(),
                                 [&](const auto& unknown) { return unknown.name == effect.name; });
    if (at == unknowns.end()) continue;
    const auto n = static_cast<Eigen::Index>(at->value.size());
    effect.estimate = Eigen::VectorXd::Map(at->value.data(), n);
    effect.sigma = Eigen::VectorXd::Map(at->sigma.data(), n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const double to_si = FindEffect(effect.name)->components[static_cast<std::size_t>(k)].to_si;
      effect.estimate[k] *= to_si;
      effect.sigma[k] *= to_si;
    }
  }
}

}  // namespace

bool NetworkFit::with_boresight() const {
  return solution->linearized().FirstColumn(solution->network().calibration().boresight().id) >= 0;
}

NetworkFitter::NetworkFitter(const Flight& flight, const GapOptions& options)
    : flight_(flight), options_(options), node_rate_hz_(DiagnosisNodeRateHz(flight)) {}

Adjustment NetworkFitter::AdjustWith(const Flight& flight, long* gnss_left_out) const {
  AdjustOptions adjust;
  adjust.with_pairs = flight.pairs.has_value() && !flight.pairs->pairs.empty();
  adjust.threads = options_.threads;
  adjust.interrupted = options_.interrupted;
  EvidenceAdjustment evidence = AdjustForEvidence(flight, adjust);
  if (gnss_left_out != nullptr) *gnss_left_out = evidence.gnss_left_out;
  return std::move(evidence.adjustment);
}

NetworkFit NetworkFitter::Fit(const std::vector<HypothesisEvidence>& chosen) const {
  const std::vector<GapCause> causes = ToCauses(chosen);
  NetworkFit fit;
  fit.chosen = chosen;
  fit.flight = std::make_unique<Flight>(flight_);
  fit.flight->config = Adapted(flight_, causes);
  AddShortOutlierNoise(flight_, causes, &fit.flight->config);
  fit.flight->config.network.node_rate_hz = node_rate_hz_;
  fit.solution =
      std::make_unique<Solution>(AdjustWith(*fit.flight, &fit.gnss_left_out), options_.threads);
  if (!chosen.empty()) TakeEstimates(fit.solution->Unknowns(), &fit.chosen);
  LibraryOptions library = MakeLibraryOptions(options_);
  for (const HypothesisEvidence& effect : chosen) library.left_out.push_back(effect.name);
  fit.screen =
      std::make_unique<Screen>(fit.solution->network(), fit.solution->marginals(), library);
  fit.effects = fit.screen->Effects();
  VarianceScreen variances =
      ScreenVariances(fit.solution->network(), fit.solution->marginals(), library);
  fit.raw_only_nats = variances.raw_only_nats;
  for (HypothesisEvidence& effect : variances.effects) fit.effects.push_back(std::move(effect));
  AddOutliers(&fit);
  SortByEvidence(&fit.effects);
  AddBoresights(&fit);
  return fit;
}

void NetworkFitter::AddBoresights(NetworkFit* fit) const {
  if (!fit->with_boresight()) return;
  const BoresightResult boresight = fit->solution->Boresight();
  SetBoresights(*fit->screen, MakeUnmodelledPrior(flight_.config),
                {boresight.angles_rad, boresight.covariance_rad2}, fit);
}

void NetworkFitter::AddOutliers(NetworkFit* fit) const {
  const auto add = [&](EffectId id, long found, long of_all, double usual,
                       const std::vector<double>& lengths_m) {
    if (Contains(fit->chosen, id) || of_all == 0) return;
    if (!MakeLibraryOptions(options_).Wanted(id)) return;
    fit->effects.push_back(OutlierEffect(id, found, of_all, usual, lengths_m));
  };
  const Adjustment& adjustment = fit->solution->adjustment();
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
  add(EffectId::kGnssOutliers, fit->gnss_left_out, static_cast<long>(network.gnss().edges().size()),
      kGoodEpochsLost, positions_m);
}

void NetworkFitter::EvaluateProcesses(NetworkFit* fit) const {
  if (fit->effects.empty()) return;
  const double best = fit->effects.front().log_evidence;
  for (HypothesisEvidence& effect : fit->effects) {
    if (!IsProcess(effect) || effect.log_evidence < kWorthJudgingNats) continue;
    // Scaled noise also fits time-correlated errors, so any process may be the true cause.
    const bool with_scaled_noise = fit->effects.front().id == EffectId::kGnssNoiseScale;
    if (effect.log_evidence < kWithinReach * best && !with_scaled_noise) continue;
    if (options_.interrupted && options_.interrupted()) throw Interrupted();
    EvaluateProcess(fit->solution->network(), options_.threads, &effect);
  }
  SortByEvidence(&fit->effects);
  HypothesisEvidence& likeliest = fit->effects.front();
  if (IsProcess(likeliest) && likeliest.log_evidence >= kWorthJudgingNats) {
    RefineProcess(fit->solution->network(), options_.threads, &likeliest);
  }
}

}  // namespace dn::diagnosis_internal
