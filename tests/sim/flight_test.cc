#include <dn/error.h>
#include <dn/rotation.h>
#include <dn/sim/simulate.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>

#include "sim/small_scenario.h"
#include "testing/temp_folder.h"

namespace dn::sim_test {

using Eigen::Vector3d;

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

std::string ReadFileText(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void Write(const SimulatedFlight& flight, const std::filesystem::path& folder) {
  OutputDirectory directory(folder);
  WriteFlight(flight, directory);
  directory.Commit();
}

constexpr const char* kEffects = R"(
effects:
  - {effect: gnss_lever_arm, value: [0.1, 0.2, -0.3]}
  - {effect: gyro_scale_factor, value: [100, -200, 300]}
  - {effect: lidar_time_offset, value: 0.001}
)";

TEST(Simulate, SeedDeterminesTheFlight) {
  const Scenario scenario = testing::SmallScenario();
  const SimulatedFlight a = Simulate(scenario, {.seed = 3});
  const SimulatedFlight b = Simulate(scenario, {.seed = 3});
  const SimulatedFlight c = Simulate(scenario, {.seed = 4});
  const auto& imu_a = a.flight.imu->samples;
  const auto& imu_b = b.flight.imu->samples;
  ASSERT_EQ(imu_a.size(), imu_b.size());
  for (std::size_t i = 0; i < imu_a.size(); i += 100) {
    EXPECT_EQ(imu_a[i].w_ib_b_radps, imu_b[i].w_ib_b_radps);
    EXPECT_EQ(imu_a[i].f_b_mps2, imu_b[i].f_b_mps2);
  }
  EXPECT_NE(imu_a[50].w_ib_b_radps, c.flight.imu->samples[50].w_ib_b_radps);
  EXPECT_EQ(a.flight.pairs->pairs[7].u_i_s, b.flight.pairs->pairs[7].u_i_s);
  EXPECT_NE(a.flight.pairs->pairs[7].u_i_s, c.flight.pairs->pairs[7].u_i_s);
  EXPECT_EQ(a.flight.gnss->epochs[5].p_m, b.flight.gnss->epochs[5].p_m);
  EXPECT_NE(a.flight.gnss->epochs[5].p_m, c.flight.gnss->epochs[5].p_m);
}

TEST(Simulate, GnssIsTheAntennaWithTheStatedNoise) {
  Scenario scenario = testing::SmallScenario(kEffects);
  scenario.gnss.velocity = true;
  scenario.pairs.count = 0;
  const Vector3d arm = scenario.gnss.lever_arm_b_m + Vector3d(0.1, 0.2, -0.3);
  const auto antenna = [&](const SimulatedFlight& flight, double t_s) -> Vector3d {
    const MapPose pose = flight.truth->Pose(t_s);
    return pose.p_mb + pose.q_mb * arm;
  };
  const SimulatedFlight clean = Simulate(scenario, {.noise = false});
  EXPECT_EQ(clean.flight.config.gnss->lever_arm_b_m, scenario.gnss.lever_arm_b_m);
  constexpr double kStep_s = 1.0 / 128.0;
  for (std::size_t i = 2; i + 2 < clean.flight.gnss->epochs.size(); i += 7) {
    const MapGnssEpoch& epoch = clean.flight.gnss->epochs[i];
    EXPECT_LT((epoch.p_m - antenna(clean, epoch.t_s)).norm(), 1e-7);
    const Vector3d v_m =
        (antenna(clean, epoch.t_s + kStep_s) - antenna(clean, epoch.t_s - kStep_s)) / (2 * kStep_s);
    const Vector3d v_enu = clean.frame.R_m_enu(antenna(clean, epoch.t_s)).transpose() * v_m;
    EXPECT_LT((v_enu - *epoch.velocity_enu_mps).norm(), 1e-3);  // second-order differences
    EXPECT_EQ(std::fmod(epoch.t_s * scenario.gnss.rate_hz, 1.0), 0.0);
  }
  const SimulatedFlight noisy = Simulate(scenario, {.seed = 6});
  Vector3d squared = Vector3d::Zero();
  for (const MapGnssEpoch& epoch : noisy.flight.gnss->epochs) {
    const Vector3d p_m = antenna(noisy, epoch.t_s);
    const Vector3d error_enu = noisy.frame.R_m_enu(p_m).transpose() * (epoch.p_m - p_m);
    squared += error_enu.cwiseQuotient(scenario.gnss.sigma_enu_m).cwiseAbs2();
  }
  const auto n = static_cast<double>(noisy.flight.gnss->epochs.size());
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(squared[axis] / n, 1.0, 5.0 * std::sqrt(2.0 / n));
  }
}

TEST(Simulate, GyroScaleFactorMultipliesTheTrueRate) {
  Scenario plain = testing::SmallScenario();
  Scenario scaled = testing::SmallScenario(kEffects);
  plain.pairs.count = scaled.pairs.count = 0;
  const SimulatedFlight a = Simulate(plain, {.noise = false});
  const SimulatedFlight b = Simulate(scaled, {.noise = false});
  const Vector3d factor = Vector3d(1.0 + 100e-6, 1.0 - 200e-6, 1.0 + 300e-6);
  for (std::size_t i = 0; i < a.flight.imu->samples.size(); i += 50) {
    const Vector3d expected = factor.cwiseProduct(a.flight.imu->samples[i].w_ib_b_radps);
    EXPECT_LT((b.flight.imu->samples[i].w_ib_b_radps - expected).norm(), 1e-15);
    EXPECT_EQ(b.flight.imu->samples[i].f_b_mps2, a.flight.imu->samples[i].f_b_mps2);
  }
  // Bias and noise cancel in the difference, because they are the same with and without the effect.
  const SimulatedFlight c = Simulate(plain, {});
  const SimulatedFlight d = Simulate(scaled, {});
  const Vector3d noise_c =
      c.flight.imu->samples[9].w_ib_b_radps - a.flight.imu->samples[9].w_ib_b_radps;
  const Vector3d noise_d =
      d.flight.imu->samples[9].w_ib_b_radps - b.flight.imu->samples[9].w_ib_b_radps;
  EXPECT_LT((noise_c - noise_d).norm(), 1e-15);
}

TEST(WriteFlight, ReadsBackAsTheFlightInMemory) {
  Scenario scenario = testing::SmallScenario(kEffects);
  scenario.gnss.velocity = true;
  const SimulatedFlight simulated = Simulate(scenario, {.seed = 12});
  const testing::TempFolder folder;
  const auto path = folder.path() / "flight";
  Write(simulated, path);
  const Flight read = ReadFlight(path, {.imu = true, .gnss = true, .pairs = true});
  const Flight& memory = simulated.flight;

  EXPECT_EQ(read.config.name, memory.config.name);
  EXPECT_EQ(read.config.imu->grade, memory.config.imu->grade);
  EXPECT_NEAR(read.config.imu->model.gyro.white, memory.config.imu->model.gyro.white, 1e-18);
  EXPECT_EQ(read.config.lidar->sigma_p_m, memory.config.lidar->sigma_p_m);
  EXPECT_EQ(read.config.lidar->mounting.boresight_rad.norm(), 0.0);
  EXPECT_EQ(read.config.lidar->mounting.lever_arm_b_m, scenario.lidar.mounting.lever_arm_b_m);
  EXPECT_EQ(read.config.gnss->lever_arm_b_m, scenario.gnss.lever_arm_b_m);
  ASSERT_EQ(read.config.strips.size(), simulated.strips.size());
  EXPECT_EQ(read.config.strips[1].t0_s, simulated.strips[1].t0_s);
  EXPECT_LT((read.frame.r0_m() - simulated.frame.r0_m()).norm(), 1e-8);

  ASSERT_EQ(read.imu->samples.size(), memory.imu->samples.size());
  // The nominal interval of the reader is a mean of differences.
  constexpr double kInterval_s = 1e-12;
  EXPECT_NEAR(read.imu->nominal_dt_s, memory.imu->nominal_dt_s, kInterval_s);
  EXPECT_NEAR(read.imu->samples[0].dt_s, memory.imu->samples[0].dt_s, kInterval_s);
  for (std::size_t i = 0; i < read.imu->samples.size(); ++i) {
    const ImuSample& a = read.imu->samples[i];
    const ImuSample& b = memory.imu->samples[i];
    ASSERT_TRUE(a.t_s == b.t_s && (i == 0 || a.dt_s == b.dt_s) &&
                a.w_ib_b_radps == b.w_ib_b_radps && a.f_b_mps2 == b.f_b_mps2)
        << i;
  }
  ASSERT_EQ(read.gnss->epochs.size(), memory.gnss->epochs.size());
  // Conversion to degrees and back: a rounding error of 6 nm each.
  constexpr double kRounding_m = 2e-8;
  for (std::size_t i = 0; i < read.gnss->epochs.size(); ++i) {
    const MapGnssEpoch& a = read.gnss->epochs[i];
    const MapGnssEpoch& b = memory.gnss->epochs[i];
    EXPECT_EQ(a.t_s, b.t_s);
    EXPECT_LT((a.p_m - b.p_m).norm(), kRounding_m);
    EXPECT_TRUE(a.covariance_enu_m2->isApprox(*b.covariance_enu_m2, 1e-14));
    EXPECT_EQ(*a.velocity_enu_mps, *b.velocity_enu_mps);
    EXPECT_EQ(a.line, b.line);
  }
  ASSERT_EQ(read.pairs->pairs.size(), memory.pairs->pairs.size());
  for (std::size_t i = 0; i < read.pairs->pairs.size(); ++i) {
    const LidarPair& a = read.pairs->pairs[i];
    const LidarPair& b = memory.pairs->pairs[i];
    EXPECT_TRUE(a.t_i_s == b.t_i_s && a.t_j_s == b.t_j_s && a.u_i_s == b.u_i_s &&
                a.u_j_s == b.u_j_s && a.file == b.file)
        << i;
  }
  ASSERT_TRUE(read.reference.has_value());
  ASSERT_EQ(read.reference->points().size(), memory.reference->points().size());
  for (std::size_t i = 0; i < read.reference->points().size(); i += 50) {
    const MapPose truth = simulated.truth->Pose(read.reference->points()[i].t_s);
    const MapPose pose = ToMapPose(read.reference->points()[i], simulated.frame);
    EXPECT_LT((pose.p_mb - truth.p_mb).norm(), 1e-7);
    EXPECT_LT(Log<double>(pose.q_mb.conjugate() * truth.q_mb).norm(), 1e-12);
    EXPECT_LT((pose.v_m - truth.v_m).norm(), 1e-9);
  }
}

TEST(WriteFlight, HolesAreBridgesOrGapsAsInAReader) {
  const SimulatedFlight simulated = Simulate(
      testing::SmallScenario("effects: [{effect: imu_gap, window_s: [381100.04, 381100.06]}, "
                             "{effect: imu_gap, window_s: [381120.04, 381120.21]}, "
                             "{effect: imu_gap, window_s: [381140.04, 381140.31]}]\n"),
      {.seed = 12});
  const testing::TempFolder folder;
  Write(simulated, folder.path() / "flight");
  const ImuData read = *ReadFlight(folder.path() / "flight", {.imu = true}).imu;
  const ImuData& memory = *simulated.flight.imu;
  ASSERT_EQ(memory.bridges.size(), 2u);
  ASSERT_EQ(memory.gaps.size(), 1u);
  ASSERT_EQ(read.bridges.size(), 2u);
  ASSERT_EQ(read.gaps.size(), 1u);
  EXPECT_NEAR(read.gaps[0].t_begin_s, memory.gaps[0].t_begin_s, 1e-9);
  EXPECT_NEAR(read.gaps[0].t_end_s, memory.gaps[0].t_end_s, 1e-9);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.bridges[i].row.w_ib_b_radps, memory.bridges[i].row.w_ib_b_radps);
    EXPECT_NEAR(read.bridges[i].gyro_sigma_rad, memory.bridges[i].gyro_sigma_rad, 1e-12);
  }
  for (std::size_t i = 0; i < read.samples.size(); ++i) {
    const ImuSample& a = read.samples[i];
    const ImuSample& b = memory.samples[i];
    ASSERT_TRUE(a.t_s == b.t_s && std::abs(a.dt_s - b.dt_s) < 1e-9 &&
                (a.w_ib_b_radps - b.w_ib_b_radps).norm() < 1e-9 &&
                (a.f_b_mps2 - b.f_b_mps2).norm() < 1e-9)
        << i;
  }
}

TEST(WriteFlight, TruthIsInTruthYamlOnly) {
  const Scenario scenario = testing::SmallScenario(kEffects);
  const SimulatedFlight simulated = Simulate(scenario, {.seed = 12});
  const testing::TempFolder folder;
  const auto path = folder.path() / "flight";
  Write(simulated, path);
  const YAML::Node truth = YAML::LoadFile((path / "truth.yaml").string());
  EXPECT_EQ(truth["scenario"].as<std::string>(), "small");
  EXPECT_EQ(truth["seed"].as<int>(), 12);
  EXPECT_NEAR(truth["boresight_deg"][2].as<double>(), 1.2, 1e-12);
  EXPECT_NEAR(truth["gnss_lever_arm_m"][0].as<double>(), 0.5, 1e-12);
  EXPECT_NEAR(truth["lidar_lever_arm_m"][0].as<double>(), 0.14, 1e-12);
  ASSERT_EQ(truth["effects"].size(), 3u);
  EXPECT_EQ(truth["effects"][1]["effect"].as<std::string>(), "gyro_scale_factor");
  EXPECT_EQ(truth["effects"][1]["value"][1].as<double>(), -200.0);
  EXPECT_EQ(truth["effects"][2]["value"].as<double>(), 0.001);
  const std::string assumed = ReadFileText(path / "flight.yaml");
  EXPECT_THAT(assumed, ::testing::Not(::testing::HasSubstr("effect")));
  EXPECT_THAT(assumed, ::testing::Not(::testing::HasSubstr("1.2")));
}

TEST(Simulate, ReplayFliesAGivenTrajectory) {
  Scenario scenario = testing::SmallScenario();
  scenario.pairs.count = 0;
  const SimulatedFlight first = Simulate(scenario, {});
  const testing::TempFolder folder;
  folder.Write("given.out", FormatSbet(first.flight.reference->points()));
  scenario.plan.replay = folder.path() / "given.out";
  scenario.plan.lines.clear();
  const SimulatedFlight again = Simulate(scenario, {});
  EXPECT_GE(again.strips.size(), 3u);
  for (double t_s = again.truth->t_begin_s(); t_s < again.truth->t_end_s(); t_s += 3.1) {
    const MapPose a = first.truth->Pose(t_s), b = again.truth->Pose(t_s);
    EXPECT_LT((a.p_mb - b.p_mb).norm(), 0.3);  // the path is smoothed over a quarter of a second
    EXPECT_LT(Log<double>(a.q_mb.conjugate() * b.q_mb).norm() * kDegPerRad, 1.5);
  }
  scenario.plan.replay = folder.path() / "missing.out";
  EXPECT_THROW(Simulate(scenario, {}), InvalidInput);
}

TEST(Simulate, AFlightWithoutLinesHasNoStripsAndNoPairs) {
  Scenario scenario = testing::SmallScenario();
  scenario.pairs.count = 0;
  const SimulatedFlight lines = Simulate(scenario, {});
  std::vector<NavPoint> turn;
  for (const NavPoint& point : lines.flight.reference->points()) {
    if (point.t_s > lines.strips[0].t1_s && point.t_s < lines.strips[1].t0_s) turn.push_back(point);
  }
  const testing::TempFolder folder;
  folder.Write("turn.out", FormatSbet(turn));
  scenario.plan.replay = folder.path() / "turn.out";
  scenario.plan.lines.clear();
  const SimulatedFlight sim = Simulate(scenario, {});
  EXPECT_TRUE(sim.strips.empty());
  EXPECT_FALSE(sim.flight.pairs);
  EXPECT_GT(sim.flight.gnss->epochs.size(), 3u);
}

TEST(Simulate, RejectsScenariosThatCannotBeFlown) {
  Scenario low = testing::SmallScenario();
  low.terrain.base_m = 195.0;
  EXPECT_THROW(Simulate(low, {}), InvalidConfig);
  Scenario apart = testing::SmallScenario();
  apart.plan.lines = {apart.plan.lines[0], apart.plan.lines[1]};
  apart.plan.lines[1].start_en_m.y() = apart.plan.lines[1].end_en_m.y() = 5000.0;
  EXPECT_THROW(Simulate(apart, {}), InvalidConfig);
}

TEST(Simulate, ReportsItsStages) {
  std::vector<std::string> stages;
  SimulateOptions options;
  options.progress = [&](const std::string& stage, double fraction) {
    EXPECT_GE(fraction, 0.0);
    EXPECT_LE(fraction, 1.0);
    if (stages.empty() || stages.back() != stage) stages.push_back(stage);
  };
  Simulate(testing::SmallScenario(), options);
  EXPECT_THAT(stages, ::testing::ElementsAre("trajectory", "imu", "gnss", "pairs"));
}

}  // namespace dn::sim_test
