#include <dn/effects/effect_table.h>
#include <dn/sim/simulate.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sim/small_scenario.h"
#include "testing/temp_folder.h"

namespace dn::sim_test {

using Eigen::Vector3d;

SimulatedFlight FlyWithErrors(const OwnErrors& own, bool noise = false) {
  SimulateOptions options;
  options.noise = noise;
  options.own = own;
  return Simulate(testing::SmallScenario(), options);
}

double LargestDifference(const ImuData& a, const ImuData& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.samples.size(); ++k) {
    largest = std::max({largest, (a.samples[k].w_ib_b_radps - b.samples[k].w_ib_b_radps).norm(),
                        (a.samples[k].f_b_mps2 - b.samples[k].f_b_mps2).norm()});
  }
  return largest;
}

double LargestDifference(const MapGnss& a, const MapGnss& b) {
  double largest_m = 0.0;
  for (std::size_t k = 0; k < a.epochs.size(); ++k) {
    largest_m = std::max(largest_m, std::abs(a.epochs[k].p_m.z() - b.epochs[k].p_m.z()));
  }
  return largest_m;
}

double LargestDifference(const PairData& a, const PairData& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.pairs.size(); ++k) {
    largest = std::max({largest, (a.pairs[k].u_i_s - b.pairs[k].u_i_s).norm(),
                        (a.pairs[k].u_j_s - b.pairs[k].u_j_s).norm(),
                        std::abs(a.pairs[k].t_i_s - b.pairs[k].t_i_s),
                        std::abs(a.pairs[k].t_j_s - b.pairs[k].t_j_s)});
  }
  return largest;
}

struct Difference {
  double imu, gnss, pairs;
};

Difference Between(const SimulatedFlight& a, const SimulatedFlight& b) {
  return {LargestDifference(*a.flight.imu, *b.flight.imu),
          LargestDifference(*a.flight.gnss, *b.flight.gnss),
          LargestDifference(*a.flight.pairs, *b.flight.pairs)};
}

TEST(OwnErrors, GyroErrorsChangeOnlyTheRates) {
  OwnErrors own;
  own.gyro_radps = [](double t_s) { return Vector3d(0.0, 1e-3 * std::sin(t_s), 0.0); };
  const SimulatedFlight plain = FlyWithErrors({}), spoilt = FlyWithErrors(own);
  const Difference d = Between(plain, spoilt);
  EXPECT_EQ(d.gnss, 0.0);
  EXPECT_EQ(d.pairs, 0.0);
  for (std::size_t k = 0; k < plain.flight.imu->samples.size(); ++k) {
    const ImuSample& before = plain.flight.imu->samples[k];
    const ImuSample& after = spoilt.flight.imu->samples[k];
    ASSERT_EQ(after.f_b_mps2, before.f_b_mps2);
    ASSERT_LT((after.w_ib_b_radps - before.w_ib_b_radps - own.gyro_radps(after.t_s)).norm(), 1e-15);
  }
}

TEST(OwnErrors, ForceErrorsChangeOnlyTheSpecificForces) {
  OwnErrors own;
  own.specific_force_mps2 = [](double t_s) { return Vector3d(0.0, 0.0, 1e-3 * std::sin(t_s)); };
  const SimulatedFlight plain = FlyWithErrors({}), spoilt = FlyWithErrors(own);
  const Difference d = Between(plain, spoilt);
  EXPECT_EQ(d.gnss, 0.0);
  EXPECT_EQ(d.pairs, 0.0);
  for (std::size_t k = 0; k < plain.flight.imu->samples.size(); ++k) {
    const ImuSample& before = plain.flight.imu->samples[k];
    const ImuSample& after = spoilt.flight.imu->samples[k];
    ASSERT_EQ(after.w_ib_b_radps, before.w_ib_b_radps);
    ASSERT_LT((after.f_b_mps2 - before.f_b_mps2 - own.specific_force_mps2(after.t_s)).norm(),
              1e-14);
  }
}

TEST(OwnErrors, AntennaErrorsChangeOnlyThePositions) {
  OwnErrors own;
  own.antenna_enu_m = [](double) { return Vector3d(0.0, 0.0, 0.25); };
  const Difference d = Between(FlyWithErrors({}), FlyWithErrors(own));
  EXPECT_EQ(d.imu, 0.0);
  EXPECT_NEAR(d.gnss, 0.25, 1e-8);
  EXPECT_EQ(d.pairs, 0.0);
}

TEST(OwnErrors, BoresightErrorEqualsTheEffect) {
  OwnErrors own;
  constexpr double kStart_s = 381200.0;
  const double to_rad = FindEffect("boresight_step")->components[0].to_si;
  own.boresight_rad = [to_rad](const MapPose& pose) {
    return pose.t_s >= kStart_s ? Vector3d(to_rad * Vector3d(0.1, -0.2, 0.3))
                                : Vector3d::Zero().eval();
  };
  SimulateOptions options;
  options.noise = false;
  const SimulatedFlight effect =
      Simulate(testing::SmallScenario(
                   "effects: [{effect: boresight_step, value: [0.1, -0.2, 0.3], t0_s: 381200}]\n"),
               options);
  const SimulatedFlight spoilt = FlyWithErrors(own);
  EXPECT_LT(Between(effect, spoilt).pairs, 1e-12);
  EXPECT_GT(Between(FlyWithErrors({}), spoilt).pairs, 0.1);
}

TEST(OwnErrors, ScannerErrorsGetTheTrueTime) {
  const SimulatedFlight plain = FlyWithErrors({});
  OwnErrors own;
  own.laser_vector = [](const Vector3d& u_s, double t_s) {
    return Vector3d((1.0 + 1e-6 * (t_s - 381000.0)) * u_s);
  };
  own.lidar_tag_shift_s = [](double) { return 0.5; };
  const SimulatedFlight spoilt = FlyWithErrors(own);
  for (std::size_t k = 0; k < plain.flight.pairs->pairs.size(); ++k) {
    const LidarPair& before = plain.flight.pairs->pairs[k];
    const LidarPair& after = spoilt.flight.pairs->pairs[k];
    ASSERT_DOUBLE_EQ(after.t_j_s, before.t_j_s + 0.5);
    const double scale = 1.0 + 1e-6 * (before.t_j_s - 381000.0);
    ASSERT_LT((after.u_j_s - scale * before.u_j_s).norm(), 1e-9);
  }
}

TEST(OwnErrors, PairErrorsGetAllPairs) {
  OwnErrors own;
  own.pairs = [](PairData* data) {
    for (LidarPair& pair : data->pairs) {
      if (pair.file == 0) pair.u_j_s.z() += 1.0;
    }
  };
  const SimulatedFlight plain = FlyWithErrors({}), spoilt = FlyWithErrors(own);
  ASSERT_GT(plain.flight.pairs->files.size(), 1U);
  for (std::size_t k = 0; k < plain.flight.pairs->pairs.size(); ++k) {
    const LidarPair& before = plain.flight.pairs->pairs[k];
    EXPECT_DOUBLE_EQ(spoilt.flight.pairs->pairs[k].u_j_s.z(),
                     before.u_j_s.z() + (before.file == 0 ? 1.0 : 0.0));
  }
}

TEST(OwnErrors, LeaveTheNoiseAsItIs) {
  OwnErrors own;
  own.antenna_enu_m = [](double) { return Vector3d(0.0, 0.0, 0.25); };
  const Difference d = Between(FlyWithErrors({}, true), FlyWithErrors(own, true));
  EXPECT_EQ(d.imu, 0.0);
  EXPECT_NEAR(d.gnss, 0.25, 1e-8);
  EXPECT_EQ(d.pairs, 0.0);
}

TEST(PlannedTimes, AgreeWithTheFlight) {
  const FlightTimes times = PlannedTimes(testing::SmallScenario(), 1);
  const SimulatedFlight flown = FlyWithErrors({});
  EXPECT_EQ(times.begin_s, flown.truth->t_begin_s());
  EXPECT_EQ(times.end_s, flown.truth->t_end_s());
  ASSERT_EQ(times.strips.size(), flown.strips.size());
  for (std::size_t i = 0; i < times.strips.size(); ++i) {
    EXPECT_EQ(times.strips[i].name, flown.strips[i].name);
    EXPECT_EQ(times.strips[i].t0_s, flown.strips[i].t0_s);
    EXPECT_EQ(times.strips[i].t1_s, flown.strips[i].t1_s);
  }
}

TEST(WriteMeasurements, LeavesTheTruthOut) {
  const testing::TempFolder folder;
  OutputDirectory directory(folder.path() / "flight");
  WriteMeasurements(FlyWithErrors({}), directory);
  directory.Commit();
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "flight" / "flight.yaml"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "flight" / "lidar" / "1_2.txt"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "flight" / "truth.yaml"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "flight" / "reference.out"));
}

}  // namespace dn::sim_test
