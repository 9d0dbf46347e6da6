#include <dn/error.h>
#include <dn/fixed_trajectory/gauss_helmert.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <functional>
#include <limits>

#include "testing/random.h"
#include "testing/strip_pairs.h"

namespace dn::fixed_trajectory_test {

using Eigen::Vector3d;
using testing::BoresightError;
using testing::Disturb;
using testing::MakeStripPairs;
using testing::StripPairOptions;
using testing::WhiteErrors;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kDeg = 0.017453292519943295;

// ---- Jacobians -------------------------------------------------------------------------------

GaussHelmertEnd RandomEnd(std::mt19937& rng) {
  GaussHelmertEnd end;
  end.q_mb = testing::RandomRotation(rng);
  end.q_mn = testing::RandomRotation(rng);
  end.p_mb = testing::RandomVector(rng, 1e3);
  end.u_b = testing::RandomVector(rng, 500.0);
  end.sigma_ned_m = Vector3d(0.02, 0.03, 0.05);
  end.sigma_rph_rad = Vector3d(1e-4, 2e-4, 3e-4);
  return end;
}

GaussHelmertPair RandomPair(std::mt19937& rng) {
  GaussHelmertPair pair;
  pair.i = RandomEnd(rng);
  pair.j = RandomEnd(rng);
  pair.covariance_m2 = 0.01 * Eigen::Matrix3d::Identity();
  return pair;
}

/// Computes central differences with one extrapolation (fourth order).
Eigen::MatrixXd Numeric(int columns, const std::function<Vector3d(const Eigen::VectorXd&)>& f) {
  constexpr double kStep = 1e-3;
  Eigen::MatrixXd J(3, columns);
  for (int c = 0; c < columns; ++c) {
    const auto slope = [&](double h) {
      const Eigen::VectorXd d = h * Eigen::VectorXd::Unit(columns, c);
      return Vector3d((f(d) - f(-d)) / (2.0 * h));
    };
    J.col(c) = (4.0 * slope(kStep / 2.0) - slope(kStep)) / 3.0;
  }
  return J;
}

class Jacobians : public ::testing::TestWithParam<BoresightModel> {};

TEST_P(Jacobians, AgreeWithNumericDifferencesAtRandomStates) {
  const BoresightModel model = GetParam();
  // Rounding of coordinates of 1e3 m divided by a step of 1e-3, for derivatives of up to 1e3 m/rad.
  constexpr double kTolerance = 1e-6;
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const GaussHelmertPair pair = RandomPair(rng);
    const Vector3d lever_arm_m = testing::RandomVector(rng, 1.0);
    const Vector3d theta = testing::RandomVector(rng, seed % 2 == 0 ? 0.01 : 1.0);
    PairCorrection v = PairCorrection::Zero();
    if (seed % 3 != 0) v = testing::RandomVector<12>(rng, seed % 3 == 1 ? 1e-3 : 0.5);
    const auto w = [&](const Vector3d& at, const PairCorrection& corrected) {
      return LinearisePair(pair, lever_arm_m, model, at, corrected).w;
    };
    const PairLinearisation analytic = LinearisePair(pair, lever_arm_m, model, theta, v);
    const Eigen::MatrixXd A = Numeric(3, [&](const Eigen::VectorXd& d) {
      const Vector3d moved = model == BoresightModel::kExponential
                                 ? Log(Eigen::Quaterniond(Exp(Vector3d(d)) * Exp(theta)))
                                 : Vector3d(theta + d);
      return w(moved, v);
    });
    const Eigen::MatrixXd B =
        Numeric(12, [&](const Eigen::VectorXd& d) { return w(theta, PairCorrection(v + d)); });
    EXPECT_LE((analytic.A - A).cwiseAbs().maxCoeff(), kTolerance);
    EXPECT_LE((analytic.B - B).cwiseAbs().maxCoeff(), kTolerance);
  }
}

INSTANTIATE_TEST_SUITE_P(GaussHelmert, Jacobians,
                         ::testing::Values(BoresightModel::kExponential,
                                           BoresightModel::kSmallAngle));

// The paper's B contains derivatives with respect to roll, pitch and heading, R_mn d R_nb / d r s.
TEST(GaussHelmert, AttitudeColumnsTimesEulerRatesAreThoseOfThePaper) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 rng(seed);
    const GaussHelmertPair pair = RandomPair(rng);
    const Vector3d theta = testing::RandomVector(rng, 0.01), a_b = testing::RandomVector(rng, 1.0);
    const Eigen::Quaterniond q_nb = pair.i.q_mn.conjugate() * pair.i.q_mb;
    const Vector3d rph = RollPitchHeading(q_nb);
    const Vector3d s = pair.i.u_b + theta.cross(pair.i.u_b) + a_b;
    const Eigen::MatrixXd paper = Numeric(3, [&](const Eigen::VectorXd& d) {
      return Vector3d(pair.i.q_mn * (QuaternionFromRollPitchHeading(rph + Vector3d(d)) * s));
    });
    const PairLinearisation ours =
        LinearisePair(pair, a_b, BoresightModel::kSmallAngle, theta, PairCorrection::Zero());
    const Eigen::Matrix3d columns =
        ours.B.middleCols<3>(3) * BodyFromEulerRates(q_nb.conjugate() * Vector3d::UnitZ());
    EXPECT_LE((columns - paper).cwiseAbs().maxCoeff(), 1e-3) << "seed " << seed;  // of 5e2 m/rad
  }
}

// ---- Estimates -------------------------------------------------------------------------------

TEST(GaussHelmert, NoiseFreeReturnsTheBoresight) {
  const StripPairOptions options;
  const GaussHelmertResult result = AdjustGaussHelmert(MakeStripPairs(options));
  // Bound from rounding of coordinates of 1e3 m over ranges of 250 m.
  EXPECT_LE((result.boresight_rad - options.boresight_rad).norm(), 1e-11);
  EXPECT_TRUE(result.converged);
  EXPECT_LE(result.sigma0, 1e-9);
  EXPECT_GT(result.residual_initial_m, 1.0);
  EXPECT_LE(result.residual_final_m, 1e-9);
  EXPECT_EQ(result.outliers, 0);
  EXPECT_EQ(result.redundancy, 3 * 300 - 3);
}

TEST(GaussHelmert, FiveDegreesOffOnEveryAxisConvergesToTheSame) {
  StripPairOptions options;
  options.boresight_rad = Vector3d(5.0, -5.0, 5.0) * kDeg;
  GaussHelmertProblem problem = MakeStripPairs(options);
  std::mt19937 rng(7);
  Disturb(&problem, WhiteErrors(rng), options.sigma_p_m, rng);
  const GaussHelmertResult far = AdjustGaussHelmert(problem);
  problem.boresight_rad = options.boresight_rad;
  const GaussHelmertResult near = AdjustGaussHelmert(problem);
  EXPECT_TRUE(far.converged);
  EXPECT_LE(far.iterations, 8);
  EXPECT_LE((far.boresight_rad - near.boresight_rad).norm(), 1e-10);  // ten times the tolerance
  EXPECT_NEAR(far.sigma0, near.sigma0, 1e-8);
}

// I + [theta]x stretches a vector perpendicular to theta by theta^2/2: at 5 deg by at least 0.4 %
// of the range.
TEST(GaussHelmert, SmallAngleLeavesTheResidueOfItsSecondOrder) {
  StripPairOptions options;
  options.boresight_rad = Vector3d(5.0, 5.0, 5.0) * kDeg;
  const GaussHelmertProblem problem = MakeStripPairs(options);
  GaussHelmertOptions small_angle;
  small_angle.model = BoresightModel::kSmallAngle;
  const GaussHelmertResult linear = AdjustGaussHelmert(problem, small_angle);
  const GaussHelmertResult exact = AdjustGaussHelmert(problem);
  EXPECT_LE(exact.residual_final_m, 1e-9);
  const double stretch_m = 0.5 * options.boresight_rad.squaredNorm() * 250.0;
  EXPECT_GT(linear.residual_final_m, 0.05 * stretch_m);  // for the difference of two points
  EXPECT_LT(linear.residual_final_m, 2.0 * stretch_m);
  const double error_deg = (linear.boresight_rad - options.boresight_rad).norm() / kDeg;
  EXPECT_GT(error_deg, 0.01);  // theta^2/2 is at most 0.65 deg
  EXPECT_LT(error_deg, 0.7);
}

TEST(GaussHelmert, SmallAngleAtZeroIsTheExponential) {
  StripPairOptions options;
  options.boresight_rad.setZero();
  GaussHelmertProblem problem = MakeStripPairs(options);
  std::mt19937 rng(3);
  Disturb(&problem, WhiteErrors(rng), options.sigma_p_m, rng);
  GaussHelmertOptions small_angle;
  small_angle.model = BoresightModel::kSmallAngle;
  const GaussHelmertResult a = AdjustGaussHelmert(problem, small_angle);
  const GaussHelmertResult b = AdjustGaussHelmert(problem);
  // The estimate is 1e-5 rad, so the models differ by its square.
  EXPECT_LE((a.boresight_rad - b.boresight_rad).norm(), 1e-9);
  EXPECT_LE((a.normal - b.normal).norm() / b.normal.norm(), 1e-4);
}

TEST(GaussHelmert, AConstantAttitudeErrorIsAbsorbedExactly) {
  const StripPairOptions options;
  GaussHelmertProblem problem = MakeStripPairs(options);
  const Vector3d offset = Vector3d(0.2, 0.05, 0.01) * kDeg;
  std::mt19937 rng(1);
  Disturb(
      &problem,
      [&](const GaussHelmertEnd&) {
        return testing::PoseError{{}, offset};
      },
      0.0, rng);
  GaussHelmertProblem without_lever_arm = problem;
  const Vector3d expected =
      Log(Eigen::Quaterniond(Exp(Vector3d(-offset)) * Exp(options.boresight_rad)));
  // The lever arm rotates with the body but not with the boresight: 0.25 m of 250 m.
  EXPECT_LE((AdjustGaussHelmert(problem).boresight_rad - expected).norm(), 5e-3 * offset.norm());
}

TEST(GaussHelmert, SigmaFollowsTheRangeAndTheNumberOfPairs) {
  StripPairOptions options;
  const GaussHelmertResult few = AdjustGaussHelmert(MakeStripPairs(options));
  options.count = 1200;
  const GaussHelmertResult many = AdjustGaussHelmert(MakeStripPairs(options));
  const Vector3d ratio =
      few.covariance_apriori_rad2.diagonal().cwiseQuotient(many.covariance_apriori_rad2.diagonal());
  // Three times the sampling error 1/sqrt(300).
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(ratio[i], 4.0, 0.8);
}

// Two opposite lines over flat ground observe only 2 h pitch - D yaw along track, so pitch and yaw
// are not separable. Relief or a cross line separates them.
TEST(GaussHelmert, ConditionOfOppositeLinesOverFlatGround) {
  StripPairOptions options;
  options.lines = {{{-800, 0, 250}, {800, 0, 250}, 1000.0},
                   {{800, 100, 250}, {-800, 100, 250}, 1100.0}};
  options.relief_m = 0.0;
  options.attitude_rad = 0.0;
  const GaussHelmertResult flat = AdjustGaussHelmert(MakeStripPairs(options));
  EXPECT_GT(flat.condition_number, 1e4);
  EXPECT_GT(std::abs(flat.correlation()(1, 2)), 0.99);
  // Along the unobservable direction 2 h beta = D gamma.
  const Eigen::Vector3d weak =
      flat.covariance_apriori_rad2.col(2) / flat.covariance_apriori_rad2(2, 2);
  EXPECT_NEAR(std::abs(weak[1]), 100.0 / 500.0, 0.02);
  const GaussHelmertResult crossing = AdjustGaussHelmert(MakeStripPairs());
  EXPECT_LT(crossing.condition_number, 50.0);
}

// ---- Covariance ------------------------------------------------------------------------------

TEST(GaussHelmert, FormalCovarianceHoldsForWhiteErrors) {
  constexpr int kRuns = 300;
  StripPairOptions options;
  options.count = 60;
  options.sigma_rph_rad = Vector3d(2e-4, 3e-4, 5e-4);  // as large as sigma_p at this range
  const GaussHelmertProblem exact = MakeStripPairs(options);
  double nees = 0.0, chi2 = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    std::mt19937 rng(static_cast<unsigned>(run));
    GaussHelmertProblem problem = exact;
    Disturb(&problem, WhiteErrors(rng), options.sigma_p_m, rng);
    GaussHelmertOptions adjust;
    adjust.outlier_medians = 0.0;  // outlier removal would bias chi2
    const GaussHelmertResult result = AdjustGaussHelmert(problem, adjust);
    const Vector3d e = BoresightError(result.boresight_rad, options.boresight_rad);
    nees += e.dot(result.normal * e);
    chi2 += result.chi2;
  }
  // The 99 % interval of chi2 with n degrees of freedom is n +- 2.58 sqrt(2 n).
  const double n = 3.0 * kRuns;
  EXPECT_NEAR(nees, n, 2.58 * std::sqrt(2.0 * n));
  const double m = kRuns * (3.0 * options.count - 3.0);
  EXPECT_NEAR(chi2, m, 2.58 * std::sqrt(2.0 * m));
}

TEST(GaussHelmert, CostSplitsIntoObservationsAndConditions) {
  StripPairOptions options;
  GaussHelmertProblem problem = MakeStripPairs(options);
  std::mt19937 rng(5);
  Disturb(&problem, WhiteErrors(rng), options.sigma_p_m, rng);
  const GaussHelmertResult result = AdjustGaussHelmert(problem);
  double observations = 0.0, conditions = 0.0;
  for (std::size_t k = 0; k < problem.pairs.size(); ++k) {
    if (result.weights[k] == 0.0) continue;
    const GaussHelmertPair& pair = problem.pairs[k];
    const PairCorrection& v = result.corrections[k];
    const Vector3d r = LinearisePair(pair, problem.lever_arm_b_m, BoresightModel::kExponential,
                                     result.boresight_rad, v)
                           .w;
    conditions += r.dot(pair.covariance_m2.inverse() * r);
    const auto weigh = [&](const GaussHelmertEnd& end, int at) {
      const Vector3d v_n = end.q_mn.conjugate() * Vector3d(v.segment<3>(at));
      observations += v_n.cwiseQuotient(end.sigma_ned_m).squaredNorm();
      const Vector3d down_b = (end.q_mb.conjugate() * end.q_mn) * Vector3d::UnitZ();
      const Vector3d rph = BodyFromEulerRates(down_b).inverse() * v.segment<3>(at + 3);
      observations += rph.cwiseQuotient(end.sigma_rph_rad).squaredNorm();
    };
    weigh(pair.i, 0);
    weigh(pair.j, 6);
  }
  constexpr double kRelative = 1e-8;
  EXPECT_NEAR(result.chi2_conditions, conditions, kRelative * conditions);
  EXPECT_NEAR(result.chi2_observations, observations, kRelative * observations);
  EXPECT_NEAR(result.chi2, observations + conditions, kRelative * result.chi2);
}

TEST(GaussHelmert, APriorHoldsWhatThePairsDoNot) {
  StripPairOptions options;
  GaussHelmertProblem problem = MakeStripPairs(options);
  problem.boresight_rad = Vector3d(0.001, 0.002, 0.003);
  problem.boresight_sigma_rad = Vector3d::Constant(1e-9);
  const GaussHelmertResult held = AdjustGaussHelmert(problem);
  EXPECT_LE((held.boresight_rad - problem.boresight_rad).norm(), 1e-9);
  EXPECT_EQ(held.redundancy, 3 * held.pairs_kept);
  problem.boresight_sigma_rad = Vector3d::Constant(1.0);
  const GaussHelmertResult free = AdjustGaussHelmert(problem);
  EXPECT_LE((free.boresight_rad - options.boresight_rad).norm(), 1e-9);
}

// ---- Outliers --------------------------------------------------------------------------------

GaussHelmertProblem WithOutliers(const StripPairOptions& options, std::size_t every,
                                 double size_m) {
  GaussHelmertProblem problem = MakeStripPairs(options);
  std::mt19937 rng(11);
  Disturb(&problem, WhiteErrors(rng), options.sigma_p_m, rng);
  for (std::size_t k = 0; k < problem.pairs.size(); k += every) {
    problem.pairs[k].j.u_b += size_m * Vector3d(1.0, 0.3, -0.2);
  }
  return problem;
}

TEST(GaussHelmert, TheOutlierRuleDropsGrossPairsOnce) {
  const StripPairOptions options;
  const GaussHelmertProblem problem = WithOutliers(options, 20, 3.0);
  GaussHelmertOptions keep;
  keep.outlier_medians = 0.0;
  const GaussHelmertResult with = AdjustGaussHelmert(problem, keep);
  const GaussHelmertResult without = AdjustGaussHelmert(problem);
  EXPECT_EQ(without.outliers, 15);
  EXPECT_EQ(without.pairs_kept, 285);
  for (std::size_t k = 0; k < problem.pairs.size(); ++k) {
    EXPECT_EQ(without.weights[k] == 0.0, k % 20 == 0) << k;
  }
  EXPECT_GT(with.sigma0, 5.0);
  EXPECT_NEAR(without.sigma0, 1.0, 0.1);
}

class RobustLoss : public ::testing::TestWithParam<Loss::Type> {};

TEST_P(RobustLoss, BoundsTheInfluenceOfGrossPairs) {
  const StripPairOptions options;
  GaussHelmertOptions robust;
  robust.loss = {GetParam(), 2.5};
  const GaussHelmertResult result = AdjustGaussHelmert(WithOutliers(options, 5, 20.0), robust);
  EXPECT_TRUE(result.converged);
  EXPECT_GE(result.outliers, 60);
  EXPECT_LE(result.outliers, 60 + 48);  // Cauchy also halves the weight of 10 % of the good pairs
  const Vector3d e = BoresightError(result.boresight_rad, options.boresight_rad);
  const double nees = e.dot(result.covariance_apriori_rad2.inverse() * e);
  // The influence is bounded but not zero: with Huber a fifth of the pairs have an influence of 2.5
  // sigma each.
  // 0.1 % quantile of chi2 with 3 degrees of freedom.
  EXPECT_LT(nees, GetParam() == Loss::Type::kHuber ? 150.0 : 16.3);
}

INSTANTIATE_TEST_SUITE_P(GaussHelmert, RobustLoss,
                         ::testing::Values(Loss::Type::kHuber, Loss::Type::kCauchy));

// ---- Threads and bad input -------------------------------------------------------------------

TEST(GaussHelmert, TheResultDoesNotDependOnTheThreads) {
  StripPairOptions options;
  options.count = 6000;
  const GaussHelmertProblem problem = WithOutliers(options, 20, 3.0);
  GaussHelmertOptions two;
  two.threads = 2;
  const GaussHelmertResult a = AdjustGaussHelmert(problem);
  const GaussHelmertResult b = AdjustGaussHelmert(problem, two);
  EXPECT_EQ(a.boresight_rad, b.boresight_rad);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.chi2, b.chi2);
}

void ExpectInvalid(const GaussHelmertProblem& problem, const std::string& what) {
  try {
    const GaussHelmertResult result = AdjustGaussHelmert(problem);
    ADD_FAILURE() << "no InvalidInput with: " << what;
  } catch (const InvalidInput& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr(what));
  }
}

TEST(GaussHelmert, RejectsBadInputByName) {
  const GaussHelmertProblem good = MakeStripPairs();
  GaussHelmertProblem bad = good;
  bad.pairs.clear();
  ExpectInvalid(bad, "the problem has 0");
  bad.pairs = {good.pairs[0]};
  ExpectInvalid(bad, "the problem has 1");
  bad.pairs.assign(10, good.pairs[0]);
  ExpectInvalid(bad, "all 10 point pairs are identical");
  bad = good;
  bad.pairs[17].i.p_mb.x() = kNan;
  ExpectInvalid(bad, "pair 17, end i: the pose");
  bad = good;
  bad.pairs[3].j.q_mb.coeffs() *= 1.1;
  ExpectInvalid(bad, "pair 3, end j: a quaternion");
  bad = good;
  bad.pairs[5].j.u_b.setZero();
  ExpectInvalid(bad, "pair 5, end j: the laser vector");
  bad = good;
  bad.pairs[6].i.sigma_rph_rad.z() = 0.0;
  ExpectInvalid(bad, "pair 6, end i: a sigma");
  bad = good;
  bad.pairs[7].i.sigma_ned_m.y() = -0.1;
  ExpectInvalid(bad, "pair 7, end i: a sigma");
  bad = good;
  bad.pairs[8].covariance_m2.setZero();
  ExpectInvalid(bad, "pair 8: the covariance");
  bad = good;
  bad.boresight_rad.y() = kNan;
  ExpectInvalid(bad, "initial boresight");
  bad = good;
  bad.boresight_sigma_rad = Vector3d(1.0, 0.0, 1.0);
  ExpectInvalid(bad, "sigma of the initial boresight");
}

// Both ends have the same attitude and the same laser vector, so the boresight cancels.
TEST(GaussHelmert, PairsThatDoNotSeeTheBoresightAreRankDeficient) {
  GaussHelmertProblem problem = MakeStripPairs();
  for (GaussHelmertPair& pair : problem.pairs) {
    pair.j = pair.i;
    pair.j.p_mb.x() += 0.01;
  }
  EXPECT_THROW(static_cast<void>(AdjustGaussHelmert(problem)), RankDeficient);
}

TEST(GaussHelmert, RejectsBadOptions) {
  const GaussHelmertProblem problem = MakeStripPairs();
  const auto expect_bad = [&](const std::function<void(GaussHelmertOptions*)>& change) {
    GaussHelmertOptions options;
    change(&options);
    EXPECT_THROW(static_cast<void>(AdjustGaussHelmert(problem, options)), InvalidConfig);
  };
  expect_bad([](GaussHelmertOptions* o) { o->outlier_medians = 0.5; });
  expect_bad([](GaussHelmertOptions* o) { o->outlier_medians = kNan; });
  expect_bad([](GaussHelmertOptions* o) { o->loss = {Loss::Type::kHuber, 0.0}; });
  expect_bad([](GaussHelmertOptions* o) { o->max_iterations = 0; });
  expect_bad([](GaussHelmertOptions* o) { o->tolerance_rad = 0.0; });
  expect_bad([](GaussHelmertOptions* o) { o->threads = 0; });
  expect_bad([](GaussHelmertOptions* o) {
    o->libor_compat = true;
    o->loss = {Loss::Type::kHuber, 2.0};
  });
}

TEST(GaussHelmert, NotToConvergeIsReported) {
  GaussHelmertOptions one;
  one.max_iterations = 1;
  const GaussHelmertResult result = AdjustGaussHelmert(MakeStripPairs(), one);
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.iterations, 1);
}

}  // namespace dn::fixed_trajectory_test
