#include <dn/adjustment/stages.h>
#include <dn/builder/build.h>
#include <dn/error.h>
#include <dn/sim/random.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <ostream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "testing/expect_invalid.h"
#include "testing/short_flights.h"
#include "testing/tolerances.h"

namespace dn::adjustment_test {

using testing::Calibration;
using testing::DroneScenario;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kSigmas;
using ::testing::ThrowsMessage;

SimulatedFlight FlyDrone(std::uint64_t seed) {
  SimulateOptions options;
  options.seed = seed;
  return Simulate(DroneScenario(), options);
}

/// Shifts a tenth of the pairs by 0.5 to 2 m.
SimulatedFlight WithWrongPairs(std::uint64_t seed) {
  SimulatedFlight sim = FlyDrone(seed);
  Random random(3, "wrong pairs");
  for (LidarPair& pair : sim.flight.pairs->pairs) {
    if (random.Uniform() > 0.1) continue;
    pair.u_j_s += random.Uniform(0.5, 2.0) * random.Normal3().normalized();
  }
  return sim;
}

/// Shifts one GNSS epoch in twenty by 0.2 to 1 m in a random direction.
SimulatedFlight WithWrongGnss(std::uint64_t seed) {
  SimulatedFlight sim = FlyDrone(seed);
  Random random(4, "wrong GNSS");
  for (MapGnssEpoch& epoch : sim.flight.gnss->epochs) {
    if (random.Uniform() > 0.05) continue;
    const Eigen::Vector3d off_m = random.Uniform(0.2, 1.0) * random.Normal3().normalized();
    epoch.p_m += off_m;
  }
  return sim;
}

TEST(Stages, TheDefaultStagesAreAList) {
  std::vector<std::string> names;
  for (const AdjustmentStage& stage : DefaultStages(false)) names.push_back(stage.name);
  EXPECT_THAT(names, ElementsAre("network", "INS/GNSS", "GNSS clock", "GNSS screening",
                                 "inertial rate", "before final", "final least squares"));
  std::vector<AdjustmentStage> all = DefaultStages();
  EXPECT_EQ(FindStage("pair rejection", &all)->name, "pair rejection");
  try {
    FindStage("pair rejections", &all);
    FAIL() << "found";
  } catch (const InvalidConfig& e) {
    EXPECT_THAT(e.what(), HasSubstr("'pair rejection'"));
  }
}

TEST(Stages, OneMayBeLeftOut) {
  const SimulatedFlight sim = WithWrongPairs(5);
  AdjustOptions options;
  options.stages = DefaultStages();
  options.stages.erase(FindStage("pair rejection", &options.stages));
  EXPECT_EQ(Adjust(sim.flight, options).outliers, 0);
  EXPECT_GT(Adjust(sim.flight).outliers, 0);
}

TEST(Stages, OneMayBeAdded) {
  const SimulatedFlight sim = FlyDrone(5);
  std::vector<std::string> solved_before;
  AdjustOptions options;
  options.stages = DefaultStages();
  options.stages.insert(FindStage("pair rejection", &options.stages),
                        {"look", [&](AdjustmentRun& run) {
                           EXPECT_EQ(&run.flight(), &sim.flight);
                           for (const StageSummary& stage : run.result().stages) {
                             solved_before.push_back(stage.name);
                           }
                           run.Solve("once more", 3);
                         }});
  const Adjustment adjustment = Adjust(sim.flight, options);
  EXPECT_THAT(solved_before, ElementsAre("INS/GNSS, robust", "lidar, robust"));
  ASSERT_GT(adjustment.stages.size(), 3U);
  EXPECT_EQ(adjustment.stages[2].name, "once more");
  EXPECT_EQ(adjustment.stages.back().name, "final least squares");
}

// This is the example of docs/reference/networks.md.
TEST(Stages, PairsMayBeJudgedTwice) {
  const SimulatedFlight sim = WithWrongPairs(5);
  AdjustOptions options;
  options.stages = DefaultStages();
  options.stages.insert(FindStage("before final", &options.stages),
                        {"pair rejection again", [](AdjustmentRun& run) {
                           run.Solve("lidar, robust again", 6);
                           RejectPairs(run);
                         }});
  const Adjustment adjustment = Adjust(sim.flight, options);
  long out = 0;
  for (const PairEdge& edge : adjustment.network->pairs().edges()) {
    out += adjustment.network->net().factor(edge.id).active ? 0 : 1;
  }
  EXPECT_GT(out, 15);
  EXPECT_EQ(adjustment.outliers, out) << "each pair counts once";
}

TEST(Stages, PairsMustBeThere) {
  SimulatedFlight sim = FlyDrone(5);
  sim.flight.pairs.reset();
  AdjustOptions options;
  options.with_pairs = false;
  options.stages = DefaultStages();
  testing::ExpectInvalid([&] { Adjust(sim.flight, options); }, "no point-to-point pairs", 0);
}

TEST(Stages, WithoutANetworkNothingCanBeSolved) {
  const SimulatedFlight sim = FlyDrone(5);
  AdjustOptions options;
  options.stages = {{"final least squares", SolveFinally}};
  EXPECT_THROW(Adjust(sim.flight, options), InvalidConfig);
  options.stages = {{"nothing", [](AdjustmentRun&) {}}};
  EXPECT_THROW(Adjust(sim.flight, options), InvalidConfig);
}

static_assert(std::is_base_of_v<Error, NotConverged>);

// A flight that ends with the statement would dangle.
template <class F>
concept IsAdjustable = requires(F&& flight) {
  Adjust(std::forward<F>(flight), AdjustOptions());
};
template <class F>
concept IsBuildable = requires(F&& flight) {
  Build(std::forward<F>(flight), NetworkDesign());
};
static_assert(IsAdjustable<const Flight&> && IsAdjustable<Flight&>);
static_assert(!IsAdjustable<Flight> && !IsAdjustable<const Flight>);
static_assert(IsBuildable<const Flight&> && !IsBuildable<Flight>);
static_assert(
    std::is_constructible_v<FlightNetwork, const Flight&, std::vector<double>, InitialStates>);
static_assert(!std::is_constructible_v<FlightNetwork, Flight, std::vector<double>, InitialStates>);
static_assert(std::is_constructible_v<AdjustmentRun, const Flight&, const AdjustOptions&>);
static_assert(!std::is_constructible_v<AdjustmentRun, Flight, const AdjustOptions&>);
static_assert(!std::is_constructible_v<AdjustmentRun, const Flight&, AdjustOptions>);

TEST(Stages, AFunctionOfTheUserIsCalledOrRefused) {
  const SimulatedFlight sim = FlyDrone(5);
  const auto own = [](FlightNetwork&) { FAIL() << "called"; };
  AdjustOptions without_pairs;
  without_pairs.with_pairs = false;
  without_pairs.customise_before_lidar = own;
  EXPECT_THAT([&] { Adjust(sim.flight, without_pairs); },
              ThrowsMessage<InvalidConfig>(HasSubstr("customise_before_lidar is not called")));
  without_pairs.customise_before_lidar = {};
  without_pairs.network.pair_model = [](FlightNetwork&) { return PairModel(); };
  EXPECT_THROW(Adjust(sim.flight, without_pairs), InvalidConfig);
  AdjustOptions own_stages;
  own_stages.with_pairs = false;
  own_stages.stages = DefaultStages(false);
  own_stages.stages.erase(FindStage("before final", &own_stages.stages));
  own_stages.customise = own;
  EXPECT_THAT([&] { Adjust(sim.flight, own_stages); },
              ThrowsMessage<InvalidConfig>(HasSubstr("the stage 'before final' that calls it")));
}

// A factor that is undefined at the values of the stage is named, wherever it is added.
TEST(Stages, AnUndefinedFactorOfTheUserIsNamed) {
  const SimulatedFlight sim = FlyDrone(5);
  const auto add = [](FlightNetwork& network) {
    using std::log;
    const FactorId id = network.net().Add([](const auto& p) { return log(-p.z() * p.z()); },
                                          Noise<1>::Sigma(1.0), network.nodes()[7].p_mb);
    network.net().Tag(id, "my altimeter", network.nodes()[7].t_s);
  };
  for (const bool before_lidar : {false, true}) {
    AdjustOptions options;
    (before_lidar ? options.customise_before_lidar : options.customise) = add;
    EXPECT_THAT([&] { Adjust(sim.flight, options); },
                ThrowsMessage<NotConverged>(::testing::AllOf(
                    HasSubstr("my altimeter"), HasSubstr("'p_mb/7'"), HasSubstr("undefined"))));
  }
}

// An altimeter with an unknown offset is added to the network by one of the two functions.
class OwnFactors : public ::testing::TestWithParam<bool> {
 protected:
  static constexpr double kOffsetM = 12.5;

  void Add(FlightNetwork& network) {
    pairs_at_call_ = network.pairs().edges().size();
    offset_ = network.net().AddScalar("altimeter offset", 0.0);
    for (std::size_t k = 100; k < 200; ++k) {
      const double reading_m = sim_.truth->Pose(network.nodes()[k].t_s).p_mb.z() - kOffsetM;
      network.net().Add([=](const auto& p_mb, const auto& o) { return p_mb.z() - o - reading_m; },
                        Noise<1>::Sigma(0.05), network.nodes()[k].p_mb, offset_);
    }
  }

  SimulatedFlight sim_ = FlyDrone(5);
  Block<Scalar> offset_;
  std::size_t pairs_at_call_ = 0;
};

TEST_P(OwnFactors, AreSeenByTheStagesThatFollow) {
  const bool before_lidar = GetParam();
  const auto add = [&](FlightNetwork& network) { Add(network); };
  AdjustOptions options;
  (before_lidar ? options.customise_before_lidar : options.customise) = add;
  options.stages = DefaultStages();
  double offset_at_rejection_m = 0.0;
  options.stages.insert(FindStage("pair rejection", &options.stages),
                        {"look", [&](AdjustmentRun& run) {
                           if (offset_.id >= 0) {
                             offset_at_rejection_m = run.network().net().Value(offset_);
                           }
                         }});
  const Adjustment adjustment = Adjust(sim_.flight, options);
  EXPECT_EQ(pairs_at_call_, sim_.flight.pairs->pairs.size());
  EXPECT_NEAR(offset_at_rejection_m, before_lidar ? kOffsetM : 0.0, 0.1);
  EXPECT_NEAR(adjustment.network->net().Value(offset_), kOffsetM, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Stages, OwnFactors, ::testing::Bool(), [](const auto& tested) {
  return tested.param ? "BeforeLidar" : "BeforeFinal";
});

/// Expects the least squares of the kept data: weights of one, chi-square equal to the redundancy,
/// and an error within the covariance.
void ExpectLeastSquares(const Calibration& c, const SimulatedFlight& sim) {
  for (const LinearizedNetwork::FactorRows& rows : c.solution.linearized().factors()) {
    ASSERT_EQ(rows.weight, 1.0) << c.solution.linearized().group(rows.factor).name;
  }
  const AdjustmentFigures& figures = c.solution.trajectory().figures;
  const auto n = static_cast<double>(figures.redundancy);
  EXPECT_NEAR(figures.chi2, c.solution.linearized().residual().squaredNorm(), 1e-6 * n);
  EXPECT_NEAR(figures.chi2 / n, 1.0, kSigmas * std::sqrt(2.0 / n));
  const Eigen::Vector3d e = c.BoresightError(sim.boresight_rad);
  EXPECT_LT(e.dot(c.boresight.covariance_rad2.ldlt().solve(e)), 25.0) << "6e-5 of chi_3^2";
  EXPECT_EQ(c.solution.CheckedBoresight().verdict, Verdict::kCalibrated);
}

class RobustKernels : public ::testing::TestWithParam<RobustKind> {};

TEST_P(RobustKernels, EndBeforeTheFinalAdjustmentOfWrongPairs) {
  SimulatedFlight sim = WithWrongPairs(8);
  sim.flight.config.lidar->robust = GetParam();
  const Calibration c(sim.flight);
  EXPECT_GT(c.adjustment.outliers, 15);
  ExpectLeastSquares(c, sim);
}

TEST_P(RobustKernels, EndBeforeTheFinalAdjustmentOfWrongGnss) {
  SimulatedFlight sim = WithWrongGnss(9);
  sim.flight.config.gnss->robust = GetParam();
  const Calibration c(sim.flight);
  EXPECT_GT(c.adjustment.gnss_rejected.size(), 5U);
  ExpectLeastSquares(c, sim);
}

constexpr auto kKernelName = [](const auto& tested) {
  if (tested.param == RobustKind::kNone) return "None";
  return tested.param == RobustKind::kHuber ? "Huber" : "Cauchy";
};

INSTANTIATE_TEST_SUITE_P(Stages, RobustKernels,
                         ::testing::Values(RobustKind::kNone, RobustKind::kCauchy), kKernelName);
INSTANTIATE_TEST_SUITE_P(ManyRuns, RobustKernels, ::testing::Values(RobustKind::kHuber),
                         kKernelName);

TEST(NodeRate, HoldsOverTheWholeFlightWithoutPairs) {
  SimulatedFlight sim = FlyDrone(2);
  AdjustOptions options;
  options.with_pairs = false;
  const Adjustment usual = Adjust(sim.flight, options);
  EXPECT_EQ(usual.node_rate_hz, 1.0);
  sim.flight.config.network.node_rate_hz = 5.0;
  const Adjustment dense = Adjust(sim.flight, options);
  EXPECT_EQ(dense.node_rate_hz, 5.0);
  const std::vector<double>& t_s = dense.network->trajectory().node_times();
  for (std::size_t k = 1; k < t_s.size(); ++k) EXPECT_LT(t_s[k] - t_s[k - 1], 0.2 + 1e-3);
  EXPECT_GT(t_s.size(), 2 * usual.network->trajectory().node_times().size());
}

TEST(NodeRate, IsNowhereBelowOneHertz) {
  SimulatedFlight sim = FlyDrone(2);
  sim.flight.config.network.node_rate_hz = 0.1;
  EXPECT_EQ(NodeRateHz(sim.flight, true), 1.0);
  EXPECT_EQ(NodeRateHz(sim.flight, false), 1.0);
}

}  // namespace dn::adjustment_test
