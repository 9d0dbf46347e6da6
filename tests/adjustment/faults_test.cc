#include <dn/adjustment/adjust.h>
#include <dn/adjustment/words.h>
#include <dn/error.h>
#include <dn/sim/random.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "testing/short_flights.h"
#include "testing/tolerances.h"

namespace dn::adjustment_test {

using testing::AircraftScenario;
using testing::Calibration;
using testing::DroneScenario;
using ::testing::HasSubstr;
using testing::kSigmas;

// Bound of a chi-square variable with three degrees of freedom; exceeded with probability 2.6e-5,
// like 4.2 sigmas of a normal variable.
constexpr double kWorstNees = 24.0;
constexpr std::uint64_t kSeed = 3;
// Without an early end these flights would take many clock steps and screenings, with several
// solutions each.
constexpr int kMostIterations = 500;

/// Every fault is tested with a small drone and with an aircraft with a navigation-grade sensor.
class Faults : public ::testing::TestWithParam<const char*> {
 protected:
  Faults() {
    SimulateOptions options;
    options.seed = kSeed;
    sim_ = Simulate(Scene(), options);
    const auto& epochs = sim_.flight.gnss->epochs;
    t0_s_ = epochs.front().t_s;
    middle_s_ = std::floor(0.5 * (t0_s_ + epochs.back().t_s));
  }

  static Scenario Scene() {
    return std::string(GetParam()) == "drone" ? DroneScenario() : AircraftScenario();
  }

  void RemoveGnss(double from_s, double to_s) {
    std::erase_if(sim_.flight.gnss->epochs,
                  [&](const MapGnssEpoch& e) { return e.t_s > from_s && e.t_s < to_s; });
  }

  void RemoveImu(double from_s, double to_s) {
    auto& samples = sim_.flight.imu->samples;
    const auto inside = [&](const ImuSample& s) { return s.t_s > from_s && s.t_s < to_s; };
    const auto first = std::find_if(samples.begin(), samples.end(), inside);
    const auto past = std::find_if_not(first, samples.end(), inside);
    if (first != samples.begin()) {
      sim_.flight.imu->gaps.push_back({std::prev(first)->t_s, past->t_s - past->dt_s});
    }
    samples.erase(first, past);
  }

  void MoveAntenna(MapGnssEpoch& epoch, const Eigen::Vector3d& offset_m) const {
    epoch.p_m += offset_m;
  }

  // Expects the boresight and every node within their covariances.
  void ExpectHonest(const Calibration& c) const {
    const Eigen::Vector3d e = c.BoresightError(sim_.boresight_rad);
    EXPECT_LT(e.cwiseQuotient(c.boresight.sigma_rad()).cwiseAbs().maxCoeff(), kSigmas);
    EXPECT_EQ(c.boresight.verdict, Verdict::kCalibrated);
    for (const NodeBlocks& node : c.adjustment.network->nodes()) {
      const Eigen::Vector3d dp =
          c.adjustment.network->net().Value(node.p_mb) - sim_.truth->Pose(node.t_s).p_mb;
      EXPECT_LT(dp.dot(c.marginals.DiagonalBlock(node.p_mb.id).ldlt().solve(dp)), kWorstNees)
          << "position at " << node.t_s - t0_s_;
    }
  }

  void ExpectRefused(const std::string& part) const {
    try {
      Adjust(sim_.flight);
      ADD_FAILURE() << "not refused";
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
  }

  SimulatedFlight sim_;
  double t0_s_ = 0.0;
  double middle_s_ = 0.0;
};

class FaultsManyRuns : public Faults {};

constexpr auto kGradeName = [](const auto& grade) { return std::string(grade.param); };

INSTANTIATE_TEST_SUITE_P(Grades, Faults, ::testing::Values("drone"), kGradeName);
INSTANTIATE_TEST_SUITE_P(ManyRuns, Faults, ::testing::Values("aircraft"), kGradeName);
INSTANTIATE_TEST_SUITE_P(Grades, FaultsManyRuns, ::testing::Values("drone", "aircraft"),
                         kGradeName);

TEST_P(Faults, ACleanFlightLosesNothing) {
  const Calibration c(sim_.flight);
  EXPECT_TRUE(c.adjustment.gnss_rejected.empty());
  EXPECT_TRUE(c.adjustment.warnings.empty());
  ExpectHonest(c);
}

TEST_P(Faults, AnOutageIsBridged) {
  RemoveGnss(middle_s_, middle_s_ + 30.0);
  const Calibration c(sim_.flight);
  EXPECT_TRUE(c.adjustment.gnss_rejected.empty());
  ExpectHonest(c);
}

TEST_P(Faults, OutliersAreFoundOneByOne) {
  constexpr double kShare = 0.05, kSmallestM = 0.3, kLargestM = 30.0;
  Random random(3, "gross errors");
  std::vector<std::size_t> bad;
  auto& epochs = sim_.flight.gnss->epochs;
  for (std::size_t k = 0; k < epochs.size(); ++k) {
    if (random.Uniform() > kShare) continue;
    MoveAntenna(epochs[k], random.Uniform(kSmallestM, kLargestM) * random.Normal3().normalized());
    bad.push_back(k);
  }
  ASSERT_GT(bad.size(), 10U);
  const Calibration c(sim_.flight);
  EXPECT_EQ(c.adjustment.gnss_rejected, bad);
  ExpectHonest(c);
}

// Jumps of seven sigmas of an epoch (a wrong ambiguity) to hundreds (a changed reference frame).
TEST_P(FaultsManyRuns, AJumpForAWhileIsFoundWhole) {
  const SimulatedFlight clean = sim_;
  for (const double jump_m : {0.1, 0.5, 5.0}) {
    SCOPED_TRACE(jump_m);
    sim_ = clean;
    std::vector<std::size_t> bad;
    auto& epochs = sim_.flight.gnss->epochs;
    for (std::size_t k = 0; k < epochs.size(); ++k) {
      if (epochs[k].t_s <= middle_s_ || epochs[k].t_s >= middle_s_ + 20.0) continue;
      MoveAntenna(epochs[k], {jump_m, 0.0, 0.0});
      bad.push_back(k);
    }
    const Calibration c(sim_.flight);
    EXPECT_EQ(c.adjustment.gnss_rejected, bad);
    ExpectHonest(c);
  }
}

TEST_P(Faults, AGapInTheInertialDataIsSurvived) {
  RemoveImu(middle_s_, middle_s_ + 0.5);
  const double in_strip_s = sim_.strips[1].t0_s + 3.0;
  RemoveImu(in_strip_s, in_strip_s + 0.5);
  const Calibration c(sim_.flight);
  EXPECT_GT(c.adjustment.network->pairs().in_imu_gaps(), 0);
  ExpectHonest(c);
}

// Each strip loses a single row and, a second later, four in a row. Both gaps are bridged without
// losing a pair.
TEST_P(Faults, LostRowsOfTheInertialDataAreBridged) {
  ImuData& imu = *sim_.flight.imu;
  for (const StripInterval& strip : sim_.strips) {
    const double middle_s = 0.5 * (strip.t0_s + strip.t1_s);
    std::erase_if(imu.samples, [&](const ImuSample& s) {
      const double since_s = s.t_s - middle_s;
      return (since_s > 0.0 && since_s <= imu.nominal_dt_s) ||
             (since_s > 1.0 && since_s <= 1.0 + 4.0 * imu.nominal_dt_s);
    });
  }
  CloseShortHoles(std::nullopt, &imu);
  ASSERT_TRUE(imu.gaps.empty());
  ASSERT_EQ(imu.bridges.size(), 2 * sim_.strips.size());
  const Calibration c(sim_.flight);
  EXPECT_EQ(c.adjustment.network->pairs().in_imu_gaps(), 0);
  EXPECT_TRUE(c.adjustment.warnings.empty());
  ExpectHonest(c);
}

TEST_P(Faults, ALostRowThatIsAGapSplitsTheChain) {
  ImuData& imu = *sim_.flight.imu;
  const double lost_s = 0.5 * (sim_.strips[1].t0_s + sim_.strips[1].t1_s);
  std::erase_if(imu.samples, [&](const ImuSample& s) {
    return s.t_s > lost_s && s.t_s <= lost_s + imu.nominal_dt_s;
  });
  CloseShortHoles(1.5 * imu.nominal_dt_s, &imu);
  ASSERT_EQ(imu.gaps.size(), 1U);
  ExpectHonest(Calibration(sim_.flight));
}

TEST_P(Faults, LateSensorsShortenTheTrajectory) {
  const SimulatedFlight clean = sim_;
  RemoveGnss(0.0, t0_s_ + 40.0);
  const Calibration late_gnss(sim_.flight);
  ExpectHonest(late_gnss);
  sim_ = clean;
  RemoveImu(0.0, t0_s_ + 40.0);
  const Calibration late_imu(sim_.flight);
  ExpectHonest(late_imu);
  EXPECT_NEAR(late_imu.adjustment.network->trajectory().node_times().front(), t0_s_ + 40.0, 1.0);
}

TEST_P(FaultsManyRuns, AClockThatStepsIsRefused) {
  const SimulatedFlight clean = sim_;
  for (const double step_s : {0.05, 1.0}) {
    sim_ = clean;
    for (MapGnssEpoch& epoch : sim_.flight.gnss->epochs) {
      if (epoch.t_s > middle_s_) epoch.t_s += step_s;
    }
    ExpectRefused("a clock steps");
    sim_ = clean;
    for (ImuSample& sample : sim_.flight.imu->samples) {
      if (sample.t_s > middle_s_) sample.t_s += step_s;
    }
    sim_.flight.imu->gaps.push_back({middle_s_, middle_s_ + step_s});
    ExpectRefused("a clock steps");
  }
}

TEST_P(Faults, AWrongInitialAttitudeIsReplaced) {
  std::vector<NavPoint> points = sim_.flight.reference->points();
  for (NavPoint& point : points) {
    point.q_nb = Exp(Eigen::Vector3d(0.0, 0.0, std::numbers::pi)) * point.q_nb;
  }
  sim_.flight.initial_guess = Trajectory(points);
  const Calibration c(sim_.flight);
  EXPECT_NE(c.adjustment.alignment_method, "initial guess");
  ExpectHonest(c);
}

// The warning names the lever arm. Its correction is about minus twice the stated value.
TEST_P(Faults, ALeverArmOfTheWrongSignIsNamed) {
  Eigen::Vector3d& lever_arm_b_m = sim_.flight.config.gnss->lever_arm_b_m;
  lever_arm_b_m *= -1.0;
  const Calibration c(sim_.flight);
  ASSERT_EQ(c.adjustment.warnings.size(), 1U);
  EXPECT_THAT(Words(c.adjustment.warnings[0]), HasSubstr("gnss.lever_arm_m"));
  EXPECT_EQ(c.boresight.verdict, Verdict::kAbsorbed);
  EXPECT_THAT(Words(c.boresight.reasons), ::testing::Contains(Words(c.adjustment.warnings[0])));
}

TEST_P(FaultsManyRuns, SigmasThatAreFarOffShowInTheInnovations) {
  for (const double ratio : {1.0, 3.0, 1.0 / 3.0}) {
    sim_.flight.config.gnss->sigma_scale = ratio;
    const Calibration c(sim_.flight);
    const TrajectoryResult& result = c.solution.trajectory();
    ASSERT_EQ(result.warnings.size(), ratio == 1.0 ? 0U : 1U) << ratio;
    if (ratio == 1.0) continue;
    EXPECT_THAT(Words(result.warnings[0]),
                HasSubstr(ratio > 1.0 ? "sigmas are too large" : "too small"));
  }
}

TEST_P(FaultsManyRuns, LateTimeTagsOfTheWholeFlightAreNamed) {
  for (MapGnssEpoch& epoch : sim_.flight.gnss->epochs) epoch.t_s += 0.05;
  const Calibration c(sim_.flight);
  EXPECT_TRUE(c.adjustment.warnings.empty());
  ASSERT_TRUE(c.adjustment.gnss_clock);
  EXPECT_NEAR(c.adjustment.gnss_clock->offset_s, 0.05,
              kSigmas * c.adjustment.gnss_clock->sigma_offset_s);
  EXPECT_EQ(c.solution.CheckedBoresight().verdict, Verdict::kContradicted);
}

TEST_P(FaultsManyRuns, SensorsThatContradictEndTheWorkEarly) {
  const std::vector<std::function<void(ImuSample&)>> mistakes{
      [](ImuSample& sample) { sample.w_ib_b_radps.z() *= -1.0; },
      [](ImuSample& sample) { sample.f_b_mps2.z() *= -1.0; },
      [](ImuSample& sample) { std::swap(sample.w_ib_b_radps.x(), sample.w_ib_b_radps.y()); },
      [](ImuSample& sample) {
        sample.w_ib_b_radps *= -1.0;
        sample.f_b_mps2 *= -1.0;
      },
      [](ImuSample& sample) { sample.w_ib_b_radps *= kDegPerRad; }};
  for (std::size_t m = 0; m < mistakes.size(); ++m) {
    SCOPED_TRACE(m);
    Flight flight = sim_.flight;
    std::ranges::for_each(flight.imu->samples, mistakes[m]);
    int iterations = 0;
    AdjustOptions options;
    options.with_pairs = false;
    options.progress = [&](const std::string&, int done) { iterations += done > 0 ? 1 : 0; };
    EXPECT_THROW(Adjust(flight, options), SensorsContradict);
    EXPECT_LE(iterations, kMostIterations);
  }
}

TEST_P(FaultsManyRuns, DataThatDoNotBelongTogetherAreRefused) {
  for (ImuSample& sample : sim_.flight.imu->samples) {
    sample.w_ib_b_radps = -sample.w_ib_b_radps;
  }
  EXPECT_THROW(Adjust(sim_.flight), std::runtime_error);
}

}  // namespace dn::adjustment_test
