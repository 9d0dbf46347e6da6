#include <dn/adjustment/plane_flight.h>
#include <dn/adjustment/trajectory_ends.h>
#include <dn/adjustment/words.h>
#include <dn/diagnosis/result_files.h>
#include <dn/error.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "testing/only_effect.h"
#include "testing/short_flights.h"
#include "testing/strip_planes.h"

namespace dn::adjustment_test {

using Eigen::Vector3d;
using testing::BoresightError;
using ::testing::HasSubstr;

constexpr double kNoiseM = 0.02;
constexpr double kSpanM = 40.0;  // ground that all three strips cover

/// The small drone on its true trajectory above planes.
struct PlaneFlight {
  Flight flight;
  Vector3d truth_rad;
  std::mt19937 rng{4};

  PlaneFlight() {
    const SimulatedFlight simulated = Simulate(testing::DroneScenario(), SimulateOptions());
    truth_rad = simulated.boresight_rad;
    flight = simulated.flight;
    flight.trajectory = flight.reference;
    flight.config.trajectory = TrajectoryConfig();
  }

  std::vector<ObservedPlane> Planes(int count, double steepest_rad, bool one_aspect = false,
                                    double range_offset_m = 0.0) {
    Mounting mounting = flight.config.lidar->mounting;
    mounting.boresight_rad = truth_rad;
    const TrajectoryEnds ends(flight);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::normal_distribution<double> noise(0.0, kNoiseM);
    const double ground_m = flight.frame.ToMap(flight.trajectory->points().front().position).z();
    const std::vector<StripInterval> strips = FindStrips(flight);
    std::vector<ObservedPlane> planes;
    for (int q = 0; q < count; ++q) {
      const Vector3d c(kSpanM * uniform(rng), kSpanM * uniform(rng),
                       std::min(0.0, ground_m) + 5.0 * uniform(rng));
      const Vector3d n = testing::SlopingNormal(steepest_rad * std::abs(uniform(rng)),
                                                one_aspect ? 0.0 : 3.14159 * uniform(rng));
      ObservedPlane& plane = planes.emplace_back();
      plane.sigma_m = kNoiseM;
      for (std::size_t s = 0; s < strips.size(); ++s) {
        const double t_s = NearestEpoch(ends, strips[s], c);
        for (int k = 0; k < 20; ++k) {
          const double at_s = t_s + 0.1 * uniform(rng);
          const GaussHelmertEnd pose = ends.At(at_s, Vector3d::UnitX());
          MapPose map;
          map.q_mb = pose.q_mb;
          map.p_mb = pose.p_mb;
          const Vector3d x = testing::OnPlane(c, n, 3.0 * uniform(rng), 3.0 * uniform(rng));
          Vector3d u_s = LaserVectorTo(map, mounting, x);
          u_s *= 1.0 + (noise(rng) + range_offset_m) / u_s.norm();
          plane.points.push_back({ends.At(at_s, u_s), static_cast<int>(s)});
        }
      }
    }
    return planes;
  }

  static double NearestEpoch(const TrajectoryEnds& ends, const StripInterval& strip,
                             const Vector3d& c) {
    double best_s = 0.0, least_m = std::numeric_limits<double>::infinity();
    for (double t_s = strip.t0_s + 0.2; t_s < strip.t1_s - 0.2; t_s += 0.1) {
      const double m = (ends.At(t_s, Vector3d::UnitX()).p_mb - c).norm();
      if (m < least_m) {
        least_m = m;
        best_s = t_s;
      }
    }
    return best_s;
  }
};

TEST(PlaneFlight, RecoversTheBoresight) {
  PlaneFlight test;
  const PlaneCalibration result = CalibratePlanes(test.flight, test.Planes(40, 0.6));
  const Vector3d error = BoresightError(result.boresight.angles_rad, test.truth_rad);
  const Vector3d sigma = result.boresight.sigma_rad();
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(error[i]), 4.0 * (*result.boresight.sigma_apriori_rad)[i]);
    EXPECT_GE(sigma[i], (*result.boresight.sigma_scaled_rad)[i]);
  }
  EXPECT_EQ(result.adjustment.planes_kept, 40);
  EXPECT_EQ(result.figures.parameters, 3 + 3 * 40);
  EXPECT_EQ(result.diversity.strips, 3);
  EXPECT_NE(result.boresight.verdict, Verdict::kContradicted);
  EXPECT_NE(result.boresight.verdict, Verdict::kNotObservable);
  ASSERT_FALSE(result.boresight.reasons.empty());
  EXPECT_THAT(Words(result.boresight.reasons.front()),
              HasSubstr("changes the distance of a point from its plane"));
}

// Errors of the beams that are larger than the noise move points off their planes.
TEST(PlaneFlight, RecoversTheBeams) {
  const double angle_rad[] = {1.5e-3, -1e-3, 0.5e-3, -1e-3}, range_m[] = {0.03, -0.04, 0.02, -0.01};
  PlaneFlight test;
  std::vector<ObservedPlane> planes = test.Planes(60, 0.6);
  const LidarConfig& lidar = *test.flight.config.lidar;
  int next = 0;
  for (ObservedPlane& plane : planes) {
    for (PlanePoint& point : plane.points) {
      const int beam = next++ % 4;
      const Vector3d u_s = lidar.mounting.R_bs_nominal.transpose() * point.end.u_b;
      const Vector3d about = u_s.cross(lidar.scan_axis_s).normalized();
      const Vector3d measured_s =
          (1.0 + range_m[beam] / u_s.norm()) * (Exp(Vector3d(-angle_rad[beam] * about)) * u_s);
      point.end.beam = beam;
      point.end.u_b = lidar.mounting.R_bs_nominal * measured_s;
    }
  }
  const PlaneCalibration without = CalibratePlanes(test.flight, planes);
  EXPECT_TRUE(without.beams.empty());
  test.flight.config.lidar->beams.emplace().count = 4;
  const PlaneCalibration result = CalibratePlanes(test.flight, planes);
  EXPECT_LT(result.figures.sigma0, 0.5 * without.figures.sigma0);
  const Vector3d error = BoresightError(result.boresight.angles_rad, test.truth_rad);
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(error[i]), 4.0 * result.boresight.sigma_rad()[i]);
  ASSERT_EQ(result.beams.size(), 2u);
  for (const BeamCorrections& beams : result.beams) {
    const bool is_angle = beams.unit == "deg";
    for (std::size_t k = 0; k < 4; ++k) {
      const double truth = is_angle ? kDegPerRad * angle_rad[k] : range_m[k];
      EXPECT_TRUE(beams.IsObservable(k)) << beams.unknown.name << " " << k;
      EXPECT_NEAR(beams.value[k], truth, 4.0 * beams.sigma[k]) << beams.unknown.name << " " << k;
      EXPECT_EQ(beams.unknown.ends[k], 60 * 3 * 20 / 4);
    }
  }
}

TEST(PlaneFlight, ResultFileHasTheKeysOfAllMethods) {
  PlaneFlight test;
  test.flight.config.estimate.push_back({.unknown = "lidar_range_offset", .sigma = {0.5}});
  PlaneCalibration result = CalibratePlanes(test.flight, test.Planes(40, 0.6, false, 0.15));
  const ModelCheck check = AssessModel(test.flight, &result);
  const Json json = CalibrationJson("x", result, check, {"1", "2", "3"}, {});
  EXPECT_EQ(json["method"], "planes");
  for (const char* key : {"correlations", "clocks", "strip_pairs"}) {
    EXPECT_TRUE(json.at(key).is_null()) << key;
  }
  for (const char* key : {"angles_deg", "euler_zyx_deg", "sigma_deg", "covariance_deg2",
                          "correlation", "sigma_apriori_deg", "sigma_scaled_deg"}) {
    EXPECT_EQ(json["boresight"].at(key).size(), 3u) << key;
  }
  EXPECT_EQ(json["planes"]["strip_pairs"]["1-3"], 40);
  const Json& offset = json["estimates"]["lidar_range_offset"];
  EXPECT_EQ(offset["unit"], "m");
  EXPECT_NEAR(offset["value"][0].get<double>(), 0.15, 4.0 * offset["sigma"][0].get<double>());
  EXPECT_LT(offset["sigma"][0].get<double>(), 0.1);
}

TEST(PlaneFlight, TheCovarianceContainsTheShiftByUnmodelledEffects) {
  constexpr double kOffsetM = 0.002;
  PlaneFlight clean, wrong;
  wrong.flight.config.unmodelled = testing::OnlyEffect(EffectId::kLidarRangeOffset, kOffsetM);
  const PlaneCalibration exact = CalibratePlanes(clean.flight, clean.Planes(40, 0.6));
  PlaneCalibration result = CalibratePlanes(wrong.flight, wrong.Planes(40, 0.6, false, kOffsetM));
  const Vector3d shift = result.boresight.angles_rad - exact.boresight.angles_rad;
  const ModelCheck check = AssessModel(wrong.flight, &result);
  ASSERT_TRUE(check.unmodelled && result.boresight.as_modelled);
  const Eigen::Matrix3d added =
      result.boresight.covariance_rad2 - result.boresight.as_modelled->covariance_rad2;
  EXPECT_LT((added - shift * shift.transpose()).norm(), 0.1 * shift.squaredNorm());
  EXPECT_LT((result.boresight.angles_rad - result.boresight.as_modelled->angles_rad).norm(), 1e-14);
  ASSERT_EQ(check.unmodelled->contributions.size(), 1u);
  EXPECT_EQ(check.unmodelled->contributions.front().effect, "lidar_range_offset");
}

// Planes alone are calibrated without reading pairs. A drift of the clock begins with the strips
// then, too.
TEST(PlaneFlight, AClockDriftBeginsWithTheStrips) {
  PlaneFlight with, without;
  without.flight.pair_strips.clear();
  without.flight.pairs.reset();
  Vector3d sigma_rad[2];
  for (PlaneFlight* test : {&with, &without}) {
    test->flight.config.unmodelled = testing::OnlyEffect(EffectId::kLidarTimeDrift, 5e-6);
    PlaneCalibration result = CalibratePlanes(test->flight, test->Planes(40, 0.6));
    ASSERT_TRUE(AssessModel(test->flight, &result).unmodelled);
    sigma_rad[test == &with ? 0 : 1] = result.boresight.sigma_rad();
  }
  EXPECT_LT((sigma_rad[0] - sigma_rad[1]).norm(), 0.5 * sigma_rad[0].norm());
}

TEST(PlaneFlight, AnEstimatedRangeOffsetIsNotUnmodelled) {
  PlaneFlight test;
  test.flight.config.unmodelled = testing::OnlyEffect(EffectId::kLidarRangeOffset, 0.05);
  test.flight.config.estimate.push_back({.unknown = "lidar_range_offset", .sigma = {0.5}});
  PlaneCalibration result = CalibratePlanes(test.flight, test.Planes(40, 0.6));
  EXPECT_FALSE(AssessModel(test.flight, &result).unmodelled);
}

TEST(PlaneFlight, TooFewPlanesAreAFindingWithTheirNumber) {
  PlaneFlight test;
  try {
    CalibratePlanes(test.flight, test.Planes(7, 0.6));
    FAIL() << "seven planes were taken for enough";
  } catch (const RankDeficient& finding) {
    EXPECT_THAT(finding.what(), HasSubstr("insufficient planes: 7 of 7"));
  }
}

TEST(PlaneFlight, TooParallelPlanesAreAFindingWithTheirSpread) {
  PlaneFlight test;
  try {
    CalibratePlanes(test.flight, test.Planes(40, 0.02));
    FAIL() << "level planes were taken for enough";
  } catch (const RankDeficient& finding) {
    EXPECT_THAT(finding.what(), HasSubstr("too parallel"));
  }
  EXPECT_THROW(CalibratePlanes(test.flight, test.Planes(40, 0.6, true)), RankDeficient);
}

TEST(PlaneFlight, LargerResidualsThanStatedContradict) {
  PlaneFlight test;
  std::vector<ObservedPlane> planes = test.Planes(40, 0.6);
  std::normal_distribution<double> waves(0.0, 1.0);
  for (ObservedPlane& plane : planes) {
    for (PlanePoint& point : plane.points) point.end.p_mb.z() += waves(test.rng);
  }
  PlaneCalibration result = CalibratePlanes(test.flight, std::move(planes));
  AssessModel(test.flight, &result);
  EXPECT_EQ(result.boresight.verdict, Verdict::kContradicted);
}

TEST(PlaneFlight, UnknownsThatPlanesLackAreNamed) {
  PlaneFlight test;
  test.flight.config.estimate.push_back({.unknown = "gnss_lever_arm"});
  const PlaneCalibration result = CalibratePlanes(test.flight, test.Planes(40, 0.6));
  EXPECT_THAT(Words(result.boresight.reasons),
              ::testing::Contains(HasSubstr("gnss_lever_arm is not estimated: the plane")));
  test.flight.config.estimate.clear();
  EXPECT_THROW(CalibratePlanes(test.flight, {}), InvalidConfig);
}

}  // namespace dn::adjustment_test
