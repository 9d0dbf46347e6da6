#include <dn/error.h>
#include <dn/fixed_trajectory/gauss_helmert.h>
#include <dn/fixed_trajectory/plane_adjustment.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>
#include <vector>

#include "testing/expect_invalid.h"
#include "testing/strip_pairs.h"
#include "testing/strip_planes.h"

namespace dn::fixed_trajectory_test {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::BoresightError;
using testing::MakeStripPairs;
using testing::MakeStripPlanes;
using testing::WhiteErrors;

constexpr int kBeams = 6;
constexpr double kAngleSigma = 1e-3, kRangeSigma = 0.03;  // rad, m

std::vector<GaussHelmertEnd*> Ends(GaussHelmertProblem* problem) {
  std::vector<GaussHelmertEnd*> ends;
  for (GaussHelmertPair& pair : problem->pairs) {
    ends.push_back(&pair.i);
    ends.push_back(&pair.j);
  }
  return ends;
}

std::vector<GaussHelmertEnd*> Ends(PlaneProblem* problem) {
  std::vector<GaussHelmertEnd*> ends;
  for (ObservedPlane& plane : problem->planes) {
    for (PlanePoint& point : plane.points) ends.push_back(&point.end);
  }
  return ends;
}

/// Returns the prior of an angle and a range of each beam. Their means are held at zero.
LaserUnknowns Unknowns() {
  LaserUnknowns laser;
  laser.start = VectorXd::Zero(2 * kBeams);
  laser.information = MatrixXd::Zero(2 * kBeams, 2 * kBeams);
  for (int k = 0; k < 2; ++k) {
    const double sigma = k == 0 ? kAngleSigma : kRangeSigma;
    laser.information.block(k * kBeams, k * kBeams, kBeams, kBeams) =
        (MatrixXd::Identity(kBeams, kBeams) + 1e6 * MatrixXd::Ones(kBeams, kBeams)) /
        (sigma * sigma);
  }
  return laser;
}

/// Returns errors of the beams without their means.
VectorXd DrawErrors(std::mt19937& rng) {
  std::normal_distribution<double> normal;
  VectorXd x(2 * kBeams);
  for (int k = 0; k < 2 * kBeams; ++k) x[k] = normal(rng);
  x.head(kBeams) = kAngleSigma * (x.head(kBeams).array() - x.head(kBeams).mean()).matrix();
  x.tail(kBeams) = kRangeSigma * (x.tail(kBeams).array() - x.tail(kBeams).mean()).matrix();
  return x;
}

/// Measures the ends with beams drawn at random, whose vectors have the errors x.
template <class Problem>
void MeasureByBeams(const VectorXd& x, std::mt19937& rng, Problem* problem) {
  problem->laser = Unknowns();
  std::uniform_int_distribution<int> beam(0, kBeams - 1);
  for (GaussHelmertEnd* end : Ends(problem)) {
    end->beam = beam(rng);
    const Vector3d along = end->u_b.normalized();
    const Vector3d ahead = Vector3d::UnitX() - along.x() * along;
    end->laser[0] = {end->beam, end->u_b.norm() * ahead.normalized()};
    end->laser[1] = {kBeams + end->beam, -along};
    end->u_b -= VectorChange(end->laser, x);
  }
}

/// Adjusts without rejecting outliers.
GaussHelmertResult AdjustAll(const GaussHelmertProblem& problem) {
  GaussHelmertOptions options;
  options.outlier_medians = 0.0;
  return AdjustGaussHelmert(problem, options);
}

PlaneAdjustment AdjustAll(const PlaneProblem& problem) {
  PlaneAdjustmentOptions options;
  options.plane_medians = options.point_sigmas = 0.0;
  return AdjustPlanes(problem, options);
}

/// Measures a problem without noise by beams, and expects that the adjustment finds their
/// errors and the boresight.
template <class Problem>
void ExpectExact(Problem problem, double most_laser, double most_rad) {
  std::mt19937 rng(3);
  const VectorXd x = DrawErrors(rng);
  MeasureByBeams(x, rng, &problem);
  problem.laser.information *= 1e-6;
  const auto result = AdjustAll(problem);
  ASSERT_TRUE(result.converged);
  EXPECT_LT((result.laser - x).template lpNorm<Eigen::Infinity>(), most_laser);
  EXPECT_LT(BoresightError(result.boresight_rad, testing::StripPairOptions().boresight_rad).norm(),
            most_rad);
}

TEST(LaserUnknowns, AreRecoveredExactly) {
  ExpectExact(MakeStripPairs(), 1e-7, 1e-8);
  ExpectExact(MakeStripPlanes(), 1e-6, 1e-7);
}

// A problem whose vectors are given at other values of the unknowns has the same solution.
TEST(LaserUnknowns, TheStartDoesNotChangeTheResult) {
  std::mt19937 rng(5);
  const VectorXd x = DrawErrors(rng), start = DrawErrors(rng);
  GaussHelmertProblem problem = MakeStripPairs();
  MeasureByBeams(x, rng, &problem);
  const GaussHelmertResult from_zero = AdjustGaussHelmert(problem);
  for (GaussHelmertEnd* end : Ends(&problem)) end->u_b += VectorChange(end->laser, start);
  problem.laser.start = start;
  const GaussHelmertResult from_start = AdjustGaussHelmert(problem);
  EXPECT_LT((from_zero.laser - from_start.laser).lpNorm<Eigen::Infinity>(), 1e-7);
  EXPECT_LT((from_zero.boresight_rad - from_start.boresight_rad).norm(), 1e-9);
}

/// Returns the squared error in the metric of its covariance. The two means are known.
double Nees(const VectorXd& error, const MatrixXd& covariance) {
  return error.dot(covariance.llt().solve(error)) / static_cast<double>(error.size() - 2);
}

TEST(LaserUnknownsManyRuns, TheCovariancesAreThoseOfTheErrors) {
  constexpr int kRuns = 60;
  double pairs = 0.0, planes = 0.0, boresight = 0.0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    std::mt19937 rng(seed);
    const VectorXd x = DrawErrors(rng);
    testing::StripPairOptions flight;
    flight.seed = seed;
    GaussHelmertProblem problem = MakeStripPairs(flight);
    Disturb(&problem, WhiteErrors(rng), flight.sigma_p_m, rng);
    MeasureByBeams(x, rng, &problem);
    const GaussHelmertResult result = AdjustAll(problem);
    pairs += Nees(result.laser - x, result.laser_covariance_apriori) / kRuns;
    const Vector3d error = BoresightError(result.boresight_rad, flight.boresight_rad);
    boresight += error.dot(result.covariance_apriori_rad2.llt().solve(error)) / 3.0 / kRuns;

    testing::StripPlaneOptions ground;
    ground.flight.seed = seed;
    ground.points = 10;
    PlaneProblem surfaces = MakeStripPlanes(ground);
    Disturb(&surfaces, WhiteErrors(rng), rng);
    MeasureByBeams(x, rng, &surfaces);
    const PlaneAdjustment fitted = AdjustAll(surfaces);
    planes += Nees(fitted.laser - x,
                   fitted.covariance_apriori.bottomRightCorner(2 * kBeams, 2 * kBeams)) /
              kRuns;
  }
  // Four standard deviations of the mean of 60 normalised squares of 10 and of 3 components.
  EXPECT_NEAR(pairs, 1.0, 0.24);
  EXPECT_NEAR(planes, 1.0, 0.24);
  EXPECT_NEAR(boresight, 1.0, 0.43);
}

// Time-correlated errors of the trajectory move the unknowns, too.
TEST(LaserUnknowns, HaveAVarianceFromCorrelatedErrors) {
  std::mt19937 rng(2);
  const testing::StripPairOptions flight;
  GaussHelmertProblem problem = MakeStripPairs(flight);
  Disturb(&problem, WhiteErrors(rng), flight.sigma_p_m, rng);
  MeasureByBeams(DrawErrors(rng), rng, &problem);
  const GaussHelmertResult result = AdjustGaussHelmert(problem);
  TrajectoryErrorOptions options;
  options.sigma_ned_m = flight.sigma_ned_m;
  options.sigma_rph_rad = flight.sigma_rph_rad;
  const CorrelatedErrorCovariance scatter =
      EstimateCorrelatedErrorCovariance(problem, result, BoresightModel::kExponential, options);
  ASSERT_EQ(scatter.other_variances.size(), 2 * kBeams);
  EXPECT_GT(scatter.other_variances.minCoeff(), 0.0);
  const VectorXd white = result.laser_covariance_apriori.diagonal();
  EXPECT_LT(scatter.other_variances.cwiseQuotient(white).maxCoeff(), 2.0);
}

TEST(LaserUnknowns, BadTermsAndPriorsAreRefused) {
  std::mt19937 rng(1);
  GaussHelmertProblem problem = MakeStripPairs();
  MeasureByBeams(DrawErrors(rng), rng, &problem);
  GaussHelmertProblem bad = problem;
  bad.pairs[7].j.laser[1].unknown = 2 * kBeams;
  testing::ExpectInvalid([&] { (void)AdjustGaussHelmert(bad); },
                         "pair 7, end j: a term of the laser vector", 0);
  bad = problem;
  bad.laser.information.setZero();
  testing::ExpectInvalid([&] { (void)AdjustGaussHelmert(bad); }, "not positive definite", 0);
  PlaneProblem planes = MakeStripPlanes();
  planes.planes[2].points[4].end.laser[0] = {0, Vector3d::UnitX()};
  testing::ExpectInvalid([&] { (void)AdjustPlanes(planes); }, "plane 2, point 4: a term", 0);
}

}  // namespace dn::fixed_trajectory_test
