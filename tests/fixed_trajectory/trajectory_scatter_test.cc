#include <dn/error.h>
#include <dn/fixed_trajectory/trajectory_scatter.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "testing/strip_pairs.h"

namespace dn::fixed_trajectory_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::FlightLine;
using testing::PoseError;
using testing::StripPairOptions;

/// A time-correlated trajectory error: six Gauss-Markov processes (position in map, attitude in
/// body) on a grid much finer than tau, plus a constant attitude error.
class CorrelatedErrors {
 public:
  CorrelatedErrors(const Vector3d& sigma_m, double position_tau_s, const Vector3d& sigma_rad,
                   double tau_s, const Vector3d& constant_rad, std::mt19937& rng)
      : constant_rad_(testing::NormalVector(rng, constant_rad)) {
    PoseError error{testing::NormalVector(rng, sigma_m), testing::NormalVector(rng, sigma_rad)};
    for (double t = kBeginS; t < kEndS; t += kStepS) {
      errors_.push_back(error);
      error.position_m = Next(error.position_m, sigma_m, position_tau_s, rng);
      error.attitude_rad = Next(error.attitude_rad, sigma_rad, tau_s, rng);
    }
  }

  PoseError operator()(const GaussHelmertEnd& end) const {
    const double at = (end.t_s - kBeginS) / kStepS;
    const auto k = static_cast<std::size_t>(at);
    const double s = at - static_cast<double>(k);
    const PoseError &a = errors_.at(k), &b = errors_.at(k + 1);
    return {(1.0 - s) * a.position_m + s * b.position_m,
            (1.0 - s) * a.attitude_rad + s * b.attitude_rad + constant_rad_};
  }

 private:
  static Vector3d Next(const Vector3d& x, const Vector3d& sigma, double tau_s, std::mt19937& rng) {
    const double decay = std::exp(-kStepS / tau_s);
    return decay * x + std::sqrt(1.0 - decay * decay) * testing::NormalVector(rng, sigma);
  }

  static constexpr double kBeginS = 990.0, kEndS = 2500.0, kStepS = 0.5;
  Vector3d constant_rad_;
  std::vector<PoseError> errors_;
};

struct Case {
  const char* name;
  std::vector<FlightLine> lines;
  double constant = 1.0;  ///< sigma of the constant attitude error / stated sigma
  double attitude = 1.0;  ///< sigma of the Gauss-Markov process of the attitude / stated sigma
  double position = 1.0;
  double tau_s = 100.0;
  SigmaSource sigma_source = SigmaSource::kDataSheet;
};

struct Consistency {
  double nees = 0.0;                  ///< mean of e^T C^-1 e; the expected value is 3
  double formal_nees = 0.0;           ///< the same with the covariance scaled by sigma0
  Vector3d width = Vector3d::Zero();  ///< rms of the stated sigma / rms of the error
};

Consistency RunMonteCarlo(const Case& test, int runs) {
  StripPairOptions options;
  options.lines = test.lines;
  options.count = 900;
  options.sigma_p_m = 0.06;
  // Between navigation and tactical grade: errors of 1 cm and 2 cm at 250 m.
  options.sigma_rph_rad = Vector3d(4e-5, 4e-5, 9e-5);
  options.sigma_ned_m = Vector3d(0.01, 0.01, 0.02);
  const GaussHelmertProblem exact = testing::MakeStripPairs(options);
  Consistency out;
  Vector3d error2 = Vector3d::Zero(), stated2 = Vector3d::Zero();
  for (int run = 0; run < runs; ++run) {
    std::mt19937 rng(static_cast<unsigned>(run));
    GaussHelmertProblem problem = exact;
    testing::Disturb(
        &problem,
        CorrelatedErrors(test.position * options.sigma_ned_m,
                         test.sigma_source == SigmaSource::kSmoother ? 10.0 : test.tau_s,
                         test.attitude * options.sigma_rph_rad, test.tau_s,
                         test.constant * options.sigma_rph_rad, rng),
        options.sigma_p_m, rng);
    const GaussHelmertResult gh = AdjustGaussHelmert(problem);
    TrajectoryErrorOptions scatter_options;
    scatter_options.sigma_ned_m = options.sigma_ned_m;
    scatter_options.sigma_rph_rad = options.sigma_rph_rad;
    scatter_options.sigma_source = test.sigma_source;
    scatter_options.max_nodes = 32;
    const CorrelatedErrorCovariance scatter = EstimateCorrelatedErrorCovariance(
        problem, gh, BoresightModel::kExponential, scatter_options);
    const Matrix3d C = ReliableCovariance(
        gh, scatter,
        scatter.constant_share * Matrix3d(options.sigma_rph_rad.cwiseAbs2().asDiagonal()));
    const Vector3d e = testing::BoresightError(gh.boresight_rad, options.boresight_rad);
    out.nees += e.dot(C.inverse() * e) / runs;
    out.formal_nees += e.dot(gh.covariance_scaled_rad2.inverse() * e) / runs;
    error2 += e.cwiseAbs2() / runs;
    stated2 += C.diagonal() / runs;
  }
  out.width = stated2.cwiseQuotient(error2).cwiseSqrt();
  return out;
}

std::vector<FlightLine> TwoLines() {
  return {{{-800, 0, 250}, {800, 0, 250}, 1000.0}, {{800, 100, 250}, {-800, 100, 250}, 1130.0}};
}

std::vector<FlightLine> FourLines() {
  std::vector<FlightLine> lines;
  for (int i = 0; i < 4; ++i) {
    const double y = 100.0 * i, x = i % 2 == 0 ? 800.0 : -800.0;
    lines.push_back({{-x, y, 250}, {x, y, 250}, 1000.0 + 100.0 * i});
  }
  return lines;
}

/// Returns the 99 % bound of the mean over runs of a chi-square with three degrees of freedom,
/// minus 3.
double NeesBound(int runs) { return 2.58 * std::sqrt(6.0 / runs); }

constexpr double kWidest = 1.5;  // at most 50 % wider than necessary
constexpr double kNarrowest = 0.75;
// Three or four strips cannot separate errors of a minute from constant ones. The estimated
// constant share may be wrong by a half.
constexpr double kUndecided = 1.3;

class Consistent : public ::testing::TestWithParam<Case> {};

TEST_P(Consistent, UnderGaussMarkovErrorsPlusAConstant) {
  constexpr int kRuns = 40;
  const Consistency result = RunMonteCarlo(GetParam(), kRuns);
  EXPECT_LE(result.nees, kUndecided * (3.0 + NeesBound(kRuns)));
  EXPECT_GE(result.nees, (3.0 - NeesBound(kRuns)) / kUndecided);
  EXPECT_LE(result.width.maxCoeff(), kWidest * kUndecided) << result.width.transpose();
  EXPECT_GE(result.width.minCoeff(), kNarrowest / kUndecided) << result.width.transpose();
  EXPECT_GT(result.formal_nees, 60.0);  // shows the need: the formal sigma is much too small
}

INSTANTIATE_TEST_SUITE_P(
    ManyRuns, Consistent,
    ::testing::Values(
        Case{"three", testing::CrossingLines(), 0.7, 0.7, 1.0, 100.0},
        Case{"four", FourLines(), 0.7, 0.7, 1.0, 100.0},
        Case{"two", TwoLines(), 0.7, 0.7, 1.0, 100.0},
        Case{"short", testing::CrossingLines(), 0.7, 0.7, 1.0, 10.0},
        Case{"long", testing::CrossingLines(), 0.7, 0.7, 1.0, 600.0},
        Case{"none", testing::CrossingLines(), 1.0, 0.01, 0.01, 100.0},
        Case{"varying", testing::CrossingLines(), 0.0, 1.0, 1.0, 60.0, SigmaSource::kSmoother},
        Case{"half", testing::CrossingLines(), 0.7, 0.7, 1.0, 100.0, SigmaSource::kSmoother},
        Case{"half_four", FourLines(), 0.7, 0.7, 1.0, 100.0, SigmaSource::kSmoother},
        Case{"constant", FourLines(), 1.0, 0.01, 1.0, 100.0, SigmaSource::kSmoother}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(CorrelatedErrorCovarianceManyRuns, NoticesThatTheStatedSigmaIsOptimistic) {
  constexpr int kRuns = 40;
  const Consistency result =
      RunMonteCarlo({"", testing::CrossingLines(), 1.0, 3.0, 3.0, 100.0}, kRuns);
  EXPECT_GT(result.formal_nees, 3.0 * 100.0);
  // With the stated size alone the value would be 3 x 10. An error of three times the stated size
  // is 2.5 sigma of the prior of a data sheet, which pulls the estimate back.
  EXPECT_LT(result.nees, 3.0 * 3.0);
}

struct OneRun {
  GaussHelmertProblem problem;
  GaussHelmertResult result;
  TrajectoryErrorOptions options;

  OneRun() {
    const StripPairOptions strips;
    problem = testing::MakeStripPairs(strips);
    std::mt19937 rng(4);
    testing::Disturb(&problem,
                     CorrelatedErrors(strips.sigma_ned_m, 100.0, strips.sigma_rph_rad, 100.0,
                                      Vector3d::Zero(), rng),
                     strips.sigma_p_m, rng);
    options.sigma_ned_m = strips.sigma_ned_m;
    options.sigma_rph_rad = strips.sigma_rph_rad;
    Adjust();
  }
  void Adjust() { result = AdjustGaussHelmert(problem); }
  CorrelatedErrorCovariance Estimate() const {
    return EstimateCorrelatedErrorCovariance(problem, result, BoresightModel::kExponential,
                                             options);
  }
};

TEST(CorrelatedErrorCovariance, FindsTheErrorsThatAreThere) {
  const CorrelatedErrorCovariance scatter = OneRun().Estimate();
  EXPECT_GT(scatter.attitude_ratio, 0.3);
  EXPECT_LT(scatter.attitude_ratio, 3.0);
  EXPECT_GT(scatter.evidence_nats, 5.0);
  EXPECT_GT(scatter.tau_s, 10.0);
  EXPECT_LE(scatter.nodes, 64);
}

TEST(CorrelatedErrorCovariance, DoesNotDependOnTheOrderOfPairsOrEnds) {
  OneRun run;
  const CorrelatedErrorCovariance before = run.Estimate();
  std::reverse(run.problem.pairs.begin(), run.problem.pairs.end());
  for (GaussHelmertPair& pair : run.problem.pairs) std::swap(pair.i, pair.j);
  run.Adjust();
  const CorrelatedErrorCovariance after = run.Estimate();
  EXPECT_LE((before.covariance_rad2 - after.covariance_rad2).norm(),
            1e-6 * before.covariance_rad2.norm());
}

TEST(CorrelatedErrorCovariance, NothingWithoutMisclosures) {
  OneRun run;
  run.problem = testing::MakeStripPairs();
  run.Adjust();
  const Vector3d sigma = run.Estimate().covariance_rad2.diagonal().cwiseSqrt();
  EXPECT_LE(sigma.maxCoeff(), 1e-9);  // with stated sigmas of at least 5e-5
}

TEST(CorrelatedErrorCovariance, TheReliableCovarianceIsTheSumOfItsParts) {
  OneRun run;
  const CorrelatedErrorCovariance scatter = run.Estimate();
  const Matrix3d constant = 1e-10 * Matrix3d::Identity();
  const auto white = [&] {
    return Matrix3d(ReliableCovariance(run.result, scatter, constant) - scatter.covariance_rad2 -
                    constant);
  };
  // Ten additional observations are 1 % of 297 x 3.
  EXPECT_LE((white() - run.result.covariance_scaled_rad2).norm(),
            0.02 * run.result.covariance_scaled_rad2.norm());
  // Two pairs that fit by chance are no evidence of small noise.
  run.result.redundancy = 3;
  run.result.chi2 = 0.1;
  run.result.sigma0 = std::sqrt(0.1 / 3.0);
  EXPECT_NEAR(white()(0, 0), 10.1 / 11.0 * run.result.covariance_apriori_rad2(0, 0),
              1e-9 * run.result.covariance_apriori_rad2(0, 0));
  run.result.sigma0 = 3.0;
  EXPECT_NEAR(white()(0, 0), 9.0 * run.result.covariance_apriori_rad2(0, 0),
              1e-9 * run.result.covariance_apriori_rad2(0, 0));
}

/// Returns the covariance of six Gauss-Markov processes of 60 s, with half of the variance constant
/// over the flight, at epochs on the lines.
PoseCovariance StatedCovariance(const StripPairOptions& strips) {
  constexpr int kEpochsPerLine = 6;
  PoseCovariance stated;
  for (std::size_t line = 0; line < strips.lines.size(); ++line) {
    for (int k = 0; k < kEpochsPerLine; ++k) {
      stated.t_s.push_back(strips.lines[line].t0_s +
                           strips.lines[line].duration_s() * k / (kEpochsPerLine - 1));
      stated.strip.push_back(static_cast<int>(line));
    }
  }
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << strips.sigma_ned_m, strips.sigma_rph_rad;
  const auto T = static_cast<Eigen::Index>(stated.t_s.size());
  stated.covariance.setZero(6 * T, 6 * T);
  for (Eigen::Index i = 0; i < T; ++i) {
    for (Eigen::Index j = 0; j < T; ++j) {
      const double apart_s = std::abs(stated.t_s[static_cast<std::size_t>(i)] -
                                      stated.t_s[static_cast<std::size_t>(j)]);
      stated.covariance.block<6, 6>(6 * i, 6 * j).diagonal() =
          (0.5 + 0.5 * std::exp(-apart_s / 60.0)) * sigma.cwiseAbs2();
    }
  }
  return stated;
}

/// A random sample of the stated errors, linear in time between the epochs of a strip.
class StatedErrors {
 public:
  StatedErrors(const PoseCovariance& stated, std::mt19937& rng) : stated_(stated) {
    std::normal_distribution<double> normal;
    const Eigen::MatrixXd L = stated.covariance.llt().matrixL();
    errors_ = L * Eigen::VectorXd::NullaryExpr(L.rows(), [&] { return normal(rng); });
  }

  PoseError operator()(const GaussHelmertEnd& end) const {
    const auto after = std::upper_bound(stated_.t_s.begin(), stated_.t_s.end() - 1, end.t_s);
    const Eigen::Index b = after - stated_.t_s.begin();
    const double x = (end.t_s - *(after - 1)) / (*after - *(after - 1));
    const Eigen::Matrix<double, 6, 1> e =
        (1.0 - x) * errors_.segment<6>(6 * (b - 1)) + x * errors_.segment<6>(6 * b);
    return {e.head<3>(), e.tail<3>()};
  }

 private:
  const PoseCovariance& stated_;
  Eigen::VectorXd errors_;
};

TEST(CorrelatedErrorCovarianceManyRuns, AStatedCovarianceGivesThatOfTheBoresight) {
  constexpr int kRuns = 200;
  StripPairOptions strips;
  strips.count = 600;
  const GaussHelmertProblem exact = testing::MakeStripPairs(strips);
  TrajectoryErrorOptions options;
  options.covariance = StatedCovariance(strips);
  double nees = 0.0, scale = 0.0;
  Vector3d error2 = Vector3d::Zero(), stated2 = Vector3d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    std::mt19937 rng(static_cast<unsigned>(run));
    GaussHelmertProblem problem = exact;
    testing::Disturb(&problem, StatedErrors(*options.covariance, rng), strips.sigma_p_m, rng);
    const GaussHelmertResult gh = AdjustGaussHelmert(problem);
    const CorrelatedErrorCovariance scatter =
        EstimateCorrelatedErrorCovariance(problem, gh, BoresightModel::kExponential, options);
    ASSERT_EQ(scatter.constant_share, 0.0);
    const Matrix3d C = ReliableCovariance(gh, scatter, Matrix3d::Zero());
    const Vector3d e = testing::BoresightError(gh.boresight_rad, strips.boresight_rad);
    nees += e.dot(C.inverse() * e) / kRuns;
    scale += scatter.attitude_ratio / kRuns;
    error2 += e.cwiseAbs2() / kRuns;
    stated2 += C.diagonal() / kRuns;
  }
  EXPECT_NEAR(nees, 3.0, 1.5 * NeesBound(kRuns));  // the scale is also estimated
  EXPECT_NEAR(scale, 1.0, 0.1);
  const Vector3d width = stated2.cwiseQuotient(error2).cwiseSqrt();
  EXPECT_LE(width.maxCoeff(), 1.2) << width.transpose();
  EXPECT_GE(width.minCoeff(), 0.85) << width.transpose();
}

TEST(CorrelatedErrorCovariance, RejectsBadCovariances) {
  const auto expect_bad = [](const auto& change) {
    OneRun run;
    run.options.covariance = StatedCovariance(StripPairOptions{});
    change(&*run.options.covariance);
    EXPECT_THROW(run.Estimate(), InvalidConfig);
  };
  expect_bad([](PoseCovariance* c) { *c = {}; });
  expect_bad([](PoseCovariance* c) { c->strip.pop_back(); });
  expect_bad([](PoseCovariance* c) { std::swap(c->t_s[1], c->t_s[2]); });
  expect_bad([](PoseCovariance* c) { c->covariance(3, 3) = 0.0; });
  expect_bad([](PoseCovariance* c) { c->covariance(3, 3) = std::nan(""); });
  expect_bad([](PoseCovariance* c) {
    c->covariance(3, 9) = c->covariance(9, 3) = 2.0 * c->covariance(3, 3);
  });
}

TEST(CorrelatedErrorCovariance, RejectsBadInput) {
  const auto expect_bad_option = [](const auto& change) {
    OneRun run;
    change(&run.options);
    EXPECT_THROW(run.Estimate(), InvalidConfig);
  };
  expect_bad_option([](TrajectoryErrorOptions* o) { o->sigma_ned_m.x() = 0.0; });
  expect_bad_option([](TrajectoryErrorOptions* o) { o->sigma_rph_rad.z() = -1.0; });
  expect_bad_option([](TrajectoryErrorOptions* o) { o->max_nodes = 1; });
  OneRun run;
  run.problem.pairs.pop_back();
  EXPECT_THROW(run.Estimate(), InvalidInput);
}

}  // namespace dn::fixed_trajectory_test
