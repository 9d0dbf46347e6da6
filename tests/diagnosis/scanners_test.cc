#include <dn/diagnosis/scanner_mountings.h>
#include <dn/diagnosis/solution.h>
#include <dn/distributions.h>
#include <dn/files/scanners.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "testing/two_scanners.h"

namespace dn::diagnosis_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using ::testing::ElementsAre;
using testing::Fly;
using ::testing::HasSubstr;
using testing::TwoScannerScenario;

SimulatedFlight FlyTwo(std::uint64_t seed, bool pure, const std::string& extra = "") {
  SimulatedFlight sim = Fly(TwoScannerScenario(150, 150, extra), seed);
  sim.flight.config.unmodelled.none = pure;
  sim.flight.config.estimate = {{.unknown = "boresight"}, {.unknown = "lidar_lever_arm"}};
  AssignScanners(ScannerNames(sim.flight.config), &sim.flight.config);
  return sim;
}

/// Returns the error of a rotation vector in the coordinates of its covariance.
Vector3d LeftError(const Vector3d& estimate_rad, const Eigen::Quaterniond& truth) {
  return Log(Eigen::Quaterniond(Exp(estimate_rad) * truth.conjugate()));
}

Eigen::Quaterniond TrueRelative(const SimulatedFlight& sim) {
  return Exp(sim.boresight_rad).conjugate() * Exp(sim.more_boresights_rad[0]);
}

Vector3d TrueArm(const SimulatedFlight& sim) {
  return sim.more_lever_arms_b_m[0] - sim.lidar_lever_arm_b_m;
}

double Nees(const Vector3d& error, const Matrix3d& covariance) {
  return error.dot(covariance.llt().solve(error));
}

TEST(Scanners, EachHasItsBoresightAndEveryTwoARelativeOne) {
  const SimulatedFlight sim = FlyTwo(1, false);
  const Solution solution(sim.flight);
  const ScannerMountings mountings = solution.CheckedMountings();
  ASSERT_EQ(mountings.scanners.size(), 2u);
  EXPECT_EQ(mountings.scanners[1].name, "b");
  const Vector3d truth[] = {sim.boresight_rad, sim.more_boresights_rad[0]};
  for (int k = 0; k < 2; ++k) {
    const BoresightResult& boresight = mountings.scanners[static_cast<std::size_t>(k)].boresight;
    EXPECT_LT(Nees(LeftError(boresight.angles_rad, Exp(truth[k])), boresight.covariance_rad2),
              20.0);
    EXPECT_EQ(boresight.verdict, Verdict::kCalibrated) << k;
    EXPECT_FALSE(boresight.contributions.empty());
  }
  const BoresightResult first = solution.CheckedBoresight();
  EXPECT_LT((first.angles_rad - mountings.scanners[0].boresight.angles_rad).norm(), 1e-12);
  EXPECT_LT((first.covariance_rad2 - mountings.scanners[0].boresight.covariance_rad2).norm(),
            1e-9 * first.covariance_rad2.norm());
  ASSERT_EQ(mountings.relative.size(), 1u);
  const RelativeMounting& relative = mountings.relative.front();
  EXPECT_EQ(relative.from + relative.to, "ab");
  EXPECT_LT(Nees(LeftError(relative.angles_rad, TrueRelative(sim)), relative.covariance_rad2),
            20.0);
  EXPECT_LT(relative.sigma_rad().z(), 0.7 * mountings.scanners[0].boresight.sigma_rad().z());
  ASSERT_TRUE(relative.lever_arm_b_m);
  EXPECT_LT(Nees(*relative.lever_arm_b_m - TrueArm(sim), relative.lever_arm_covariance_m2), 20.0);
  Json json;
  AddScannersJson(mountings, &json);
  EXPECT_EQ(json["scanners"][1]["name"], "b");
  EXPECT_EQ(json["relative_boresight"][0]["scanners"], Json({"a", "b"}));
  EXPECT_THAT(ScannersSummary(mountings), HasSubstr("a to b"));
}

// The predicted covariances are those of the same geometry, and the effects outside of the model
// make them larger.
TEST(Scanners, MountingsArePredictedWithoutResiduals) {
  const SimulatedFlight sim = FlyTwo(2, false);
  const Solution solution(sim.flight);
  const ScannerMountings predicted = solution.PredictedMountings();
  const ScannerMountings pure =
      ExtractMountings(solution.adjustment(), solution.marginals(), nullptr);
  ASSERT_EQ(predicted.relative.size(), 1u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_GE(predicted.relative[0].sigma_rad()[i], pure.relative[0].sigma_rad()[i]);
    EXPECT_GE(predicted.scanners[1].boresight.sigma_rad()[i],
              pure.scanners[1].boresight.sigma_rad()[i]);
  }
}

TEST(Scanners, AnEffectOfOneIsFoundWithItsName) {
  Scenario scenario =
      TwoScannerScenario(300, 300, "effects: [{effect: lidar_range_offset, value: [0.4]}]\n");
  scenario.effects[0].scanner = "b";
  SimulatedFlight sim = Fly(scenario, 3);
  const Solution solution(sim.flight);
  std::vector<std::string> found;
  for (const EffectCheck& effect : solution.model_check().effects) found.push_back(effect.name);
  EXPECT_THAT(found, ::testing::Contains("lidar_range_offset/b"));
  EXPECT_THAT(found, ::testing::Not(::testing::Contains("lidar_range_offset")));
  EstimateEntry offset{.unknown = "lidar_range_offset"};
  offset.scanner = "b";
  sim.flight.config.estimate.push_back(offset);
  AssignScanners(ScannerNames(sim.flight.config), &sim.flight.config);
  const std::vector<UnknownEstimate> unknowns = Solution(sim.flight).Unknowns();
  ASSERT_EQ(unknowns.size(), 1u);
  EXPECT_EQ(unknowns[0].name, "lidar_range_offset/b");
  EXPECT_NEAR(unknowns[0].value[0], 0.4, 4.0 * unknowns[0].sigma[0]);
  EXPECT_LT(unknowns[0].sigma[0], 0.1);
}

// A scanner without pairs of its own is calibrated by those with another.
TEST(Scanners, PairsBetweenCalibrateAScannerWithoutItsOwn) {
  SimulatedFlight sim = FlyTwo(4, true);
  std::erase_if(sim.flight.pairs->pairs,
                [](const LidarPair& pair) { return pair.scanner_i == 1 && pair.scanner_j == 1; });
  const Solution solution(sim.flight);
  const ScannerMountings mountings =
      ExtractMountings(solution.adjustment(), solution.marginals(), nullptr);
  const RelativeMounting& relative = mountings.relative.front();
  EXPECT_LT(Nees(LeftError(relative.angles_rad, TrueRelative(sim)), relative.covariance_rad2),
            20.0);
  EXPECT_EQ(mountings.scanners[1].boresight.verdict, Verdict::kCalibrated);
}

/// Returns the flight with the pairs of one scanner alone.
Flight WithOneScanner(Flight flight, int scanner) {
  FlightConfig& config = flight.config;
  std::erase_if(flight.pairs->pairs, [&](const LidarPair& pair) {
    return pair.scanner_i != scanner || pair.scanner_j != scanner;
  });
  for (LidarPair& pair : flight.pairs->pairs) pair.scanner_i = pair.scanner_j = 0;
  config.lidar = LidarConfig(ScannerAt(config, static_cast<std::size_t>(scanner)));
  config.more_scanners.clear();
  config.pairs_between.clear();
  config.estimate = {{.unknown = "boresight"}, {.unknown = "lidar_lever_arm"}};
  return flight;
}

struct Relative {
  Eigen::Quaterniond rotation;
  double variance = 0.0;  // sum over the axes
};

/// Returns the difference of two separate calibrations; its variances are those of both together.
Relative Separate(const SimulatedFlight& sim) {
  Relative out{Eigen::Quaterniond::Identity()};
  for (int k = 0; k < 2; ++k) {
    const Flight flight = WithOneScanner(sim.flight, k);
    const BoresightResult boresight = Solution(flight).Boresight();
    const Eigen::Quaterniond q = Exp(boresight.angles_rad);
    out.rotation = k == 0 ? q.conjugate() : out.rotation * q;
    out.variance += boresight.covariance_rad2.trace();
  }
  return out;
}

// The errors that the scanners share cancel: the joint relative boresight is better than the
// difference of two calibrations by the ratio of their sigmas.
TEST(ScannersSlowRuns, TheRelativeMountingIsWithinItsSigmas) {
  constexpr int kFlights = 20;
  double nees = 0.0, nees_arm = 0.0, joint2 = 0.0, separate2 = 0.0;
  double joint_variance = 0.0, separate_variance = 0.0;
  for (int seed = 1; seed <= kFlights; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const SimulatedFlight sim = FlyTwo(static_cast<std::uint64_t>(seed), true);
    const Solution solution(sim.flight);
    const RelativeMounting relative =
        ExtractMountings(solution.adjustment(), solution.marginals(), nullptr).relative.front();
    const Vector3d error = LeftError(relative.angles_rad, TrueRelative(sim));
    nees += Nees(error, relative.covariance_rad2);
    nees_arm += Nees(*relative.lever_arm_b_m - TrueArm(sim), relative.lever_arm_covariance_m2);
    joint2 += error.squaredNorm();
    joint_variance += relative.covariance_rad2.trace();
    const Relative separate = Separate(sim);
    separate2 += LeftError(Log(separate.rotation), TrueRelative(sim)).squaredNorm();
    separate_variance += separate.variance;
  }
  const double lower = ChiSquareQuantile(0.005, 3 * kFlights);
  const double upper = ChiSquareQuantile(0.995, 3 * kFlights);
  EXPECT_GT(nees, lower);
  EXPECT_LT(nees, upper);
  EXPECT_GT(nees_arm, lower);
  EXPECT_LT(nees_arm, upper);
  const double foretold = std::sqrt(separate_variance / joint_variance);
  EXPECT_GT(foretold, 1.5);
  // The ratio of two root mean squares over 60 errors has a relative sigma of 13 %; the bounds are
  // three of these.
  const double found = std::sqrt(separate2 / joint2);
  EXPECT_GT(found, 0.6 * foretold);
  EXPECT_LT(found, 1.4 * foretold);
  RecordProperty("nees_per_dof", std::to_string(nees / (3 * kFlights)));
  RecordProperty("nees_arm_per_dof", std::to_string(nees_arm / (3 * kFlights)));
  RecordProperty("foretold", std::to_string(foretold));
  RecordProperty("found", std::to_string(found));
}

}  // namespace dn::diagnosis_test
