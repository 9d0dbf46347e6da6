#include "held_out.h"

#include <dn/solvers/prediction.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "testing/short_flights.h"

namespace dn::diagnosis_internal {

using testing::DroneScenario;

Flight Drone(const std::string& effects = "", std::uint64_t seed = 1) {
  SimulateOptions options;
  options.seed = seed;
  return Simulate(DroneScenario(effects), options).flight;
}

/// Returns an effect with its estimate, SI.
HypothesisEvidence Estimated(EffectId id, const Eigen::VectorXd& estimate) {
  HypothesisEvidence effect{MakeHypothesis(id), {}};
  effect.estimate = estimate;
  effect.sigma = Eigen::VectorXd::Zero(estimate.size());
  return effect;
}

HypothesisEvidence RangeOffset() {
  return Estimated(EffectId::kLidarRangeOffset, Eigen::VectorXd::Constant(1, 0.1));
}

/// A flight adjusted without and with one effect in the estimator.
struct BothSides {
  explicit BothSides(Flight of) : flight(std::move(of)), fitter(flight, options) {
    without = fitter.Fit({});
    with = fitter.Fit({RangeOffset()});
  }

  Flight flight;
  GapOptions options;
  NetworkFitter fitter;
  NetworkFit without, with;
};

TEST(Folds, EveryPairLiesInOneTile) {
  const Flight flight = Drone();
  const testing::Calibration adjusted(flight);
  const FlightNetwork& network = adjusted.solution.network();
  const std::vector<Fold> folds = MakeFolds(network, 6);
  std::set<std::pair<double, double>> seen;
  std::size_t tiles = 0, in_tiles = 0;
  for (const Fold& fold : folds) {
    if (fold.pairs_t_s.empty()) continue;
    ++tiles;
    in_tiles += fold.pairs_t_s.size();
    seen.insert(fold.pairs_t_s.begin(), fold.pairs_t_s.end());
    const double even = static_cast<double>(network.pairs().edges().size()) / 6.0;
    EXPECT_NEAR(static_cast<double>(fold.pairs_t_s.size()), even, 1.0);
  }
  EXPECT_EQ(tiles, 6u);
  EXPECT_EQ(in_tiles, network.pairs().edges().size());
  EXPECT_EQ(seen.size(), network.pairs().edges().size());
}

TEST(Folds, OutagesLastHalfAMinute) {
  const Flight flight = Drone();
  const testing::Calibration adjusted(flight);
  const double begin_s = adjusted.solution.network().trajectory().node_times().front();
  int outages = 0;
  for (const Fold& fold : MakeFolds(adjusted.solution.network(), 3)) {
    if (fold.gnss_epochs.empty()) continue;
    std::set<int> turns;  // periods of 180 s
    double first_s = 0.0;
    for (const std::size_t epoch : fold.gnss_epochs) {
      const double t_s = flight.gnss->epochs[epoch].t_s - begin_s;
      const bool begins = turns.insert(static_cast<int>(t_s / 180.0)).second;
      if (begins) first_s = t_s;
      EXPECT_LT(t_s - first_s, 30.0);
    }
    ++outages;
  }
  EXPECT_EQ(outages, 3);
}

TEST(FoldDensity, OfOneFactorIsThatOfItsPrediction) {
  const Flight flight = Drone();
  const testing::Calibration adjusted(flight);
  const FlightNetwork& network = adjusted.solution.network();
  const FoldDensity density(network.net(), {});
  constexpr double kRelative = 1e-6;  // a small difference of two large sums
  for (const std::size_t k : {0u, 40u, 200u}) {
    const GnssEdge& edge = network.gnss().edges()[k];
    const Prediction prediction = PredictFactor(adjusted.marginals, edge.position);
    const Eigen::Vector3d sigma_m(0.015, 0.015, 0.03);
    const double expected = -0.5 * prediction.statistic -
                            0.5 * std::log(prediction.covariance.determinant()) -
                            sigma_m.array().log().sum() - 1.5 * std::log(2.0 * std::numbers::pi);
    const auto found = density.LogDensity({{edge.position, network.nodes()[edge.node].p_mb.id}});
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR((*found)[0], expected, kRelative * std::abs(expected));
  }
}

TEST(HeldOut, AnEffectThatIsThereGainsWhatItsEvidenceSays) {
  const BothSides both(Drone("effects: [{effect: lidar_range_offset, value: 0.1}]"));
  const HeldOutGains gains = MeasureHeldOut(both.without, both.with, {});
  double evidence = 0.0;
  for (const HypothesisEvidence& effect : both.without.effects) {
    if (effect.name == "lidar_range_offset") evidence = effect.log_evidence;
  }
  EXPECT_EQ(gains.folds, 12);
  ASSERT_GT(evidence, 15.0);
  // Evidence includes a penalty for the unknown size. In a fold, the other data already determine
  // most of the size, so the penalty is smaller.
  EXPECT_GT(gains.gain_nats, 0.6 * evidence);
  EXPECT_LT(gains.gain_nats, 1.6 * evidence);
  ASSERT_TRUE(gains.cause_gains[0].has_value());
  EXPECT_EQ(*gains.cause_gains[0], gains.gain_nats);
  // The remaining gain is that of the best of many effects in noise.
  EXPECT_LT(gains.further_nats, 8.0);
}

TEST(HeldOut, WhatIsMissingCouldBeReached) {
  const Flight flight = Drone("effects: [{effect: lidar_range_offset, value: 0.1}]");
  const GapOptions options;
  const NetworkFitter fitter(flight, options);
  const NetworkFit without = fitter.Fit({});
  const HeldOutGains gains = MeasureHeldOut(without, without, {});
  EXPECT_EQ(gains.gain_nats, 0.0);
  const BothSides both(flight);
  const double by_estimate = MeasureHeldOut(both.without, both.with, {}).gain_nats;
  EXPECT_NEAR(gains.further_nats, by_estimate, 0.2 * by_estimate);
}

TEST(HeldOut, AnEffectThatIsNotThereGainsNothing) {
  const BothSides both(Drone());
  const HeldOutGains gains = MeasureHeldOut(both.without, both.with, {});
  constexpr double kNats = 3.0;  // size estimated from noise in each of 12 folds
  EXPECT_LT(gains.gain_nats, kNats);
  EXPECT_GT(gains.gain_nats, -kNats);
}

TEST(HeldOut, EachOfTwoCausesIsHeldAgainstTheOther) {
  const Flight flight = Drone(
      "effects: [{effect: lidar_range_offset, value: 0.1}, "
      "{effect: gnss_lever_arm, value: [0.3, 0, 0]}]");
  const GapOptions options;
  const NetworkFitter fitter(flight, options);
  const HypothesisEvidence arm = Estimated(EffectId::kGnssLeverArm, Eigen::Vector3d(0.3, 0, 0));
  const NetworkFit without = fitter.Fit({});
  const NetworkFit with = fitter.Fit({RangeOffset(), arm});
  const HeldOutGains gains = MeasureHeldOut(without, with, {});
  ASSERT_TRUE(gains.cause_gains[0] && gains.cause_gains[1]);
  const NetworkFit only_arm = fitter.Fit({arm});
  const double beside_the_arm = MeasureHeldOut(only_arm, with, {}).gain_nats;
  constexpr double kRelative = 0.05;  // one linear step against an adjustment
  EXPECT_NEAR(*gains.cause_gains[0], beside_the_arm, kRelative * beside_the_arm);
  EXPECT_GT(*gains.cause_gains[1], 5.0);
}

TEST(HeldOut, NoiseOfAnotherSizeCountsByItsDensity) {
  const Flight flight = Drone("effects: [{effect: gnss_noise_scale, value: 2}]");
  const GapOptions options;
  const NetworkFitter fitter(flight, options);
  HypothesisEvidence scale =
      Estimated(EffectId::kGnssNoiseScale, Eigen::VectorXd::Constant(1, 2.0));
  const NetworkFit without = fitter.Fit({}), right = fitter.Fit({scale});
  scale.estimate[0] = 8.0;
  const NetworkFit too_large = fitter.Fit({scale});
  EXPECT_GT(MeasureHeldOut(without, right, {}).gain_nats, 50.0);
  EXPECT_LT(MeasureHeldOut(right, too_large, {}).gain_nats, -50.0);
}

}  // namespace dn::diagnosis_internal
