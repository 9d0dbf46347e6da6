#include <dn/distributions.h>
#include <dn/error.h>
#include <dn/fixed_trajectory/plane_adjustment.h>
#include <gmock/gmock.h>

#include <Eigen/LU>
#include <limits>

#include "testing/strip_planes.h"

namespace dn::fixed_trajectory_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::Disturb;
using ::testing::HasSubstr;
using testing::MakeStripPlanes;
using testing::PoseError;
using testing::StripPlaneOptions;

PoseError NoError(const GaussHelmertEnd&) { return {}; }

TEST(PlanePoint, JacobiansAreThoseOfDifferences) {
  const PlaneProblem problem = MakeStripPlanes();
  const Vector3d theta(0.02, -0.03, 0.05);
  const double rho = 0.4;
  constexpr double kStep = 1e-5;
  constexpr double kTolerance = 1e-6;  // at 250 m; second derivatives times the squared step
  for (const std::size_t q : {0u, 7u, 33u}) {
    const PlanePoint& point = problem.planes[q].points[3];
    const PlaneState plane{point.end.p_mb - Vector3d(3.0, 2.0, 240.0),
                           testing::SlopingNormal(0.3 + 0.1 * static_cast<double>(q % 4), 1.0),
                           0.7};
    const auto f = [&](const Vector3d& d_theta, double d_rho, const Vector3d& t,
                       const Vector3d& phi) {
      PlanePoint moved = point;
      moved.end.q_mb = moved.end.q_mb * Exp(phi);
      const Vector3d at = Log(Eigen::Quaterniond(Exp(d_theta) * Exp(theta)));
      return LinearisePlanePoint(moved, 0.02, problem.lever_arm_b_m, at, rho + d_rho,
                                 Changed(plane, t))
          .f_m;
    };
    const PlanePointLinearisation at =
        LinearisePlanePoint(point, 0.02, problem.lever_arm_b_m, theta, rho, plane);
    const Vector3d zero = Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      const Vector3d h = kStep * Vector3d::Unit(i);
      const double scale = 0.5 / kStep;
      EXPECT_NEAR(at.J_theta[i], scale * (f(h, 0, zero, zero) - f(-h, 0, zero, zero)),
                  250.0 * kTolerance);
      EXPECT_NEAR(at.J_plane[i], scale * (f(zero, 0, h, zero) - f(zero, 0, -h, zero)),
                  250.0 * kTolerance);
      EXPECT_NEAR(at.J_phi[i], scale * (f(zero, 0, zero, h) - f(zero, 0, zero, -h)),
                  250.0 * kTolerance);
    }
    EXPECT_NEAR(at.J_range,
                (f(zero, kStep, zero, zero) - f(zero, -kStep, zero, zero)) * 0.5 / kStep,
                kTolerance);
  }
}

// Hand calculation: the scanner looks down at a level plane 100 m below and 50 m to the right.
TEST(PlanePoint, VarianceByHand) {
  PlanePoint point;
  point.end.q_mn = point.end.q_mb =
      Eigen::Quaterniond(Eigen::AngleAxisd(3.14159265358979, Vector3d::UnitX()));
  point.end.u_b = Vector3d(0.0, 50.0, 100.0);  // to the right and down
  point.end.sigma_ned_m = Vector3d(0.5, 0.5, 0.03);
  point.end.sigma_rph_rad = Vector3d(1e-3, 2e-3, 3e-3);
  const PlanePointLinearisation at =
      LinearisePlanePoint(point, 0.04, Vector3d::Zero(), Vector3d::Zero(), 0.0, PlaneState{});
  // Roll lifts a point 50 m to the side by 50 m times the roll; pitch and heading do not.
  EXPECT_NEAR(at.variance_m2, 0.03 * 0.03 + 0.05 * 0.05 + 0.04 * 0.04, 1e-12);
}

TEST(PlaneAdjustment, RecoversTheTruthWithoutNoise) {
  StripPlaneOptions options;
  PlaneProblem problem = MakeStripPlanes(options);
  const PlaneAdjustment result = AdjustPlanes(problem);
  EXPECT_TRUE(result.converged);
  EXPECT_LT((result.boresight_rad - options.flight.boresight_rad).norm(), 1e-8);
  EXPECT_EQ(result.planes_kept, options.count);
  EXPECT_GT(result.residual_initial_m, 0.1);
  EXPECT_LT(result.residual_final_m, 1e-6);

  for (ObservedPlane& plane : problem.planes) {
    for (PlanePoint& point : plane.points) point.end.u_b *= 1.0 + 0.25 / point.end.u_b.norm();
  }
  problem.with_range_offset = true;
  const PlaneAdjustment with_range = AdjustPlanes(problem);
  EXPECT_NEAR(with_range.range_offset_m, 0.25, 1e-6);
  EXPECT_LT((with_range.boresight_rad - options.flight.boresight_rad).norm(), 1e-8);
}

TEST(PlaneAdjustment, ThreadsChangeNothing) {
  PlaneProblem problem = MakeStripPlanes();
  std::mt19937 rng(2);
  Disturb(&problem, NoError, rng);
  PlaneAdjustmentOptions options;
  const PlaneAdjustment one = AdjustPlanes(problem, options);
  options.threads = 3;
  EXPECT_EQ(AdjustPlanes(problem, options).boresight_rad, one.boresight_rad);
}

// N^-1 is the covariance if the errors are independent between points.
TEST(PlaneAdjustment, ScatterOfManyDrawsIsTheCovariance) {
  constexpr int kRuns = 200;
  StripPlaneOptions options;
  options.count = 40;
  options.points = 12;
  const PlaneProblem exact = MakeStripPlanes(options);
  PlaneAdjustmentOptions adjust;
  adjust.plane_medians = adjust.point_sigmas = 0.0;
  std::mt19937 rng(11);
  double nees = 0.0, chi2 = 0.0;
  long redundancy = 0;
  for (int run = 0; run < kRuns; ++run) {
    PlaneProblem problem = exact;
    Disturb(&problem, testing::WhiteErrors(rng), rng);
    const PlaneAdjustment result = AdjustPlanes(problem, adjust);
    ASSERT_TRUE(result.converged);
    const Vector3d error =
        testing::BoresightError(result.boresight_rad, options.flight.boresight_rad);
    nees += error.dot(result.normal * error) / 3.0 / kRuns;
    chi2 += result.chi2;
    redundancy += result.redundancy;
  }
  EXPECT_TRUE(ChiSquareInterval(0.99, 3.0 * kRuns).Contains(nees)) << nees;
  const auto dof = static_cast<double>(redundancy);
  // First-order approximation; 4 sigma of sampling error are 0.015.
  EXPECT_NEAR(chi2 / dof, 1.0, 0.01);
}

TEST(PlaneAdjustment, WrongMatchesAndPointsAreLeftOut) {
  StripPlaneOptions options;
  PlaneProblem problem = MakeStripPlanes(options);
  std::mt19937 rng(3);
  Disturb(&problem, NoError, rng);
  for (std::size_t q = 0; q < 12; ++q) {  // one in five: the second strip observed another roof
    const int strip = problem.planes[q].points.back().strip;
    for (PlanePoint& point : problem.planes[q].points) {
      if (point.strip == strip) point.end.p_mb.z() += q % 2 == 0 ? 1.0 : -2.0;
    }
  }
  problem.planes[20].points[4].end.u_b *= 1.0006;  // 0.15 m
  const PlaneAdjustment result = AdjustPlanes(problem);
  EXPECT_EQ(result.planes_kept, 48);
  EXPECT_EQ(result.kept[20][4], 0);
  EXPECT_LT(static_cast<double>(result.points_left_out),
            0.02 * static_cast<double>(result.points_kept));
  const Vector3d error =
      testing::BoresightError(result.boresight_rad, options.flight.boresight_rad);
  EXPECT_LT(error.dot(result.normal * error), ChiSquareQuantile(0.999, 3.0));
}

TEST(PlaneAdjustment, PlanesOfOneAspectAreWeak) {
  StripPlaneOptions options;
  const NormalSpread all = AdjustPlanes(MakeStripPlanes(options)).normals;
  EXPECT_NEAR(all.eigenvalues.sum(), 1.0, 1e-12);
  EXPECT_GT(all.eigenvalues[0], 0.03);
  options.one_aspect = true;
  EXPECT_LT(AdjustPlanes(MakeStripPlanes(options)).normals.eigenvalues[0], 1e-6);
}

TEST(PlaneAdjustment, NoPlaneOfTwoStripsIsRankDeficient) {
  PlaneProblem problem = MakeStripPlanes();
  for (ObservedPlane& plane : problem.planes) {
    for (PlanePoint& point : plane.points) point.strip = 0;
  }
  EXPECT_THROW(std::ignore = AdjustPlanes(problem), RankDeficient);
  problem.planes.clear();
  EXPECT_THROW(std::ignore = AdjustPlanes(problem), RankDeficient);
}

TEST(PlaneAdjustment, RejectsBadInputByName) {
  const PlaneProblem good = MakeStripPlanes();
  PlaneProblem bad = good;
  bad.planes[5].points[2].end.u_b.setZero();
  try {
    std::ignore = AdjustPlanes(bad);
    FAIL();
  } catch (const InvalidInput& e) {
    EXPECT_THAT(e.what(), HasSubstr("plane 5, point 2: the laser vector is zero"));
  }
  bad = good;
  bad.planes[5].sigma_m = 0.0;
  EXPECT_THROW(std::ignore = AdjustPlanes(bad), InvalidInput);
  bad = good;
  bad.planes[1].points[0].end.sigma_rph_rad.setZero();
  EXPECT_THROW(std::ignore = AdjustPlanes(bad), InvalidInput);
  EXPECT_THROW(std::ignore = AdjustPlanes(good, {.plane_medians = 0.5}), InvalidConfig);
  EXPECT_THROW(std::ignore = AdjustPlanes(good, {.tolerance_rad = 0.0}), InvalidConfig);
}

// With errors that are constant over a strip, the boresight varies much more than the normal matrix
// predicts. It varies about as much as the reliable covariance predicts.
TEST(PlaneErrorCovariance, CoversErrorsThatLast) {
  constexpr int kRuns = 40;
  StripPlaneOptions options;
  options.count = 60;
  options.points = 12;
  const PlaneProblem exact = MakeStripPlanes(options);
  TrajectoryErrorOptions scatter_options;
  scatter_options.sigma_ned_m = options.flight.sigma_ned_m;
  scatter_options.sigma_rph_rad = options.flight.sigma_rph_rad;
  scatter_options.max_nodes = 9;
  std::mt19937 rng(5);
  double nees = 0.0, formal = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    PlaneProblem problem = exact;
    std::vector<Vector3d> attitude, position;
    for (int s = 0; s < 3; ++s) {
      attitude.push_back(testing::NormalVector(rng, options.flight.sigma_rph_rad));
      position.push_back(testing::NormalVector(rng, options.flight.sigma_ned_m));
    }
    const auto errors = [&](const GaussHelmertEnd& end) {
      const std::size_t s = end.t_s < 1100.0 ? 0 : end.t_s < 1230.0 ? 1 : 2;
      return PoseError{position[s], attitude[s]};
    };
    Disturb(&problem, errors, rng);
    const PlaneAdjustment result = AdjustPlanes(problem);
    const PlaneErrorCovariance scatter =
        EstimateCorrelatedErrorCovariance(problem, result, scatter_options);
    const Matrix3d attitude_rad2 =
        options.flight.sigma_rph_rad.cwiseAbs2().asDiagonal().toDenseMatrix() *
        scatter.trajectory.constant_share;
    const Matrix3d C = ReliableCovariance(result, scatter.trajectory, attitude_rad2);
    const Vector3d error =
        testing::BoresightError(result.boresight_rad, options.flight.boresight_rad);
    nees += error.dot(C.inverse() * error) / 3.0 / kRuns;
    formal += error.dot(result.covariance_scaled_rad2.inverse() * error) / 3.0 / kRuns;
  }
  EXPECT_GT(formal, 3.0);
  EXPECT_GT(nees, 0.3);
  EXPECT_LT(nees, 1.5);
}

TEST(PlaneErrorCovariance, IsThatOfTheStatedCovariance) {
  StripPlaneOptions options;
  options.points = 12;
  PlaneProblem problem = MakeStripPlanes(options);
  problem.with_range_offset = true;
  std::mt19937 rng(6);
  Disturb(&problem, testing::WhiteErrors(rng), rng);
  const PlaneAdjustment result = AdjustPlanes(problem);
  PoseCovariance stated;
  stated.t_s = {1000.0, 1036.0, 1130.0, 1166.0, 1260.0, 1296.0};
  stated.strip = {0, 0, 1, 1, 2, 2};
  stated.covariance = 1e-8 * Eigen::MatrixXd::Identity(36, 36);
  TrajectoryErrorOptions scatter_options;
  scatter_options.covariance = stated;
  const PlaneErrorCovariance small =
      EstimateCorrelatedErrorCovariance(problem, result, scatter_options);
  EXPECT_GT(small.range_offset_m2, 0.0);
  scatter_options.covariance->covariance *= 1e-4;
  const PlaneErrorCovariance tiny =
      EstimateCorrelatedErrorCovariance(problem, result, scatter_options);
  EXPECT_LT(tiny.trajectory.covariance_rad2.trace(),
            1e-3 * small.trajectory.covariance_rad2.trace());
  EXPECT_THROW(EstimateCorrelatedErrorCovariance(PlaneProblem{}, result, scatter_options),
               InvalidInput);
}

}  // namespace dn::fixed_trajectory_test
