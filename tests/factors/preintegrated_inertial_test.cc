#include <dn/error.h>
#include <dn/factors/preintegrated_inertial.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "testing/earth_motion.h"
#include "testing/factor_consistency.h"
#include "testing/random.h"

namespace dn::factors_test {

using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::EarthMotion;
using testing::State;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

const PreintegrationNoise kAirinsNoise{0.002 * kRadPerDeg / 60.0, 10e-6 * kStandardGravityMps2,
                                       1e-6};

Preintegrated Increments(const EarthMotion& motion, double t0_s, double t1_s,
                         const ImuCorrection& bias = {}) {
  return Preintegrate(motion.Measure(t0_s - 0.05, t1_s + 0.05, 200.0), t0_s, t1_s, bias,
                      kAirinsNoise);
}

PreintegratedInertial Factor(const EarthMotion& motion, const Preintegrated& pre) {
  return {pre, motion.frame, motion.Pose(pre.t_begin_s).p_mb, motion.Pose(pre.t_end_s).p_mb, 1, 1};
}

std::vector<VectorXd> States(const MapPose& i, const MapPose& j) {
  return {State(i.q_mb), i.p_mb, i.v_m, State(j.q_mb), j.p_mb, j.v_m};
}

std::vector<VectorXd> WithBiases(std::vector<VectorXd> x, const Vector3d& b_g = Vector3d::Zero(),
                                 const Vector3d& b_a = Vector3d::Zero()) {
  x.push_back(b_g);
  x.push_back(b_a);
  return x;
}

Vector9 EvaluateInertial(const FactorBase& factor, const std::vector<VectorXd>& x) {
  std::vector<const double*> pointers;
  for (const VectorXd& block : x) pointers.push_back(block.data());
  Vector9 r;
  EXPECT_TRUE(factor.Evaluate(pointers.data(), r.data(), nullptr));
  return r;
}

/// Returns the unwhitened tangent Jacobian of a block.
Eigen::Matrix<double, 9, 3> Jacobian(const FactorBase& factor, const std::vector<VectorXd>& x,
                                     std::size_t block, const Matrix9& covariance) {
  using RowMajor = Eigen::Matrix<double, 9, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<const double*> pointers;
  for (const VectorXd& value : x) pointers.push_back(value.data());
  RowMajor stored(9, x[block].size());
  std::vector<double*> J(x.size(), nullptr);
  J[block] = stored.data();
  Vector9 r;
  EXPECT_TRUE(factor.Evaluate(pointers.data(), r.data(), J.data()));
  const Matrix9 L = covariance.llt().matrixL();
  return L * (stored * PlusJacobian(factor.block_kinds()[block], x[block].data()));
}

// A closed-form motion over the rotating Earth, simulated in Coriolis form, must give a zero
// residual. The tolerance is hundredths of the noise of a navigation-grade sensor.
TEST(PreintegratedInertial, VanishesOnAnAnalyticFlight) {
  const EarthMotion motion = testing::PlaneMotion();
  for (const double length_s : {0.005, 0.0173, 0.1, 0.2, 1.0}) {
    SCOPED_TRACE("length " + std::to_string(length_s));
    const Preintegrated pre = Increments(motion, 3.0031, 3.0031 + length_s);
    const Vector9 r =
        EvaluateInertial(Factor(motion, pre),
                         WithBiases(States(motion.Pose(pre.t_begin_s), motion.Pose(pre.t_end_s))));
    EXPECT_LE(r.lpNorm<Eigen::Infinity>(), 0.02) << r.transpose();
  }
}

// Hand calculation: the end is shifted by (1, 2, 3) m and rotated by a milliradian, and all sigmas
// are 2.
TEST(PreintegratedInertial, ResidualOfAShift) {
  const EarthMotion motion = testing::PlaneMotion();
  Preintegrated pre = Increments(motion, 3.0, 3.1);
  pre.covariance = Vector9(Vector9::Constant(4.0)).asDiagonal();
  const PreintegratedInertial factor = Factor(motion, pre);
  MapPose j = motion.Pose(3.1);
  const Vector9 at_truth = EvaluateInertial(factor, WithBiases(States(motion.Pose(3.0), j)));
  j.p_mb += Vector3d(1.0, 2.0, 3.0);
  j.q_mb = j.q_mb * Exp(Vector3d(1e-3, 0.0, 0.0));
  const Vector9 change =
      EvaluateInertial(factor, WithBiases(States(motion.Pose(3.0), j))) - at_truth;
  const Vector3d shift = motion.Pose(3.0).q_mb.conjugate() * Vector3d(0.5, 1.0, 1.5);
  EXPECT_LE((change.head<3>() - Vector3d(5e-4, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_LE((change.tail<3>() - shift).norm(), 1e-4);  // rotated by the Earth by 7e-6 rad
  EXPECT_LE(change.segment<3>(3).norm(), 1e-3);        // w x 3.7 m / 2
}

TEST(PreintegratedInertial, JacobiansAgreeAtRandomStates) {
  const EarthMotion motion = testing::PlaneMotion();
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const double length_s = std::uniform_real_distribution<double>(0.005, 1.0)(rng);
    Preintegrated pre =
        Increments(motion, 3.0, 3.0 + length_s,
                   {testing::RandomVector(rng, 1e-3), testing::RandomVector(rng, 0.1)});
    const int num_gyro = static_cast<int>(seed % 3), num_accel = static_cast<int>(seed / 3 % 3);
    std::vector<GravitationBasis> attraction;
    if (seed % 2 == 1) {  // two effects of the sensors and one on gravitation
      pre.linearisation.effects = {{nullptr, testing::RandomVector(rng, 1e-3)},
                                   {nullptr, testing::RandomVector(rng, 1e-3).head<1>()}};
      pre.J_effects = Eigen::MatrixXd::NullaryExpr(
          9, 4, [&](auto, auto) { return std::uniform_real_distribution<double>(-1, 1)(rng); });
      attraction = {Eigen::Matrix<double, 3, 2>::Ones()};
    }
    // Numeric differentiation needs sigmas of similar size; the whitening matrix is tested below.
    const Matrix9 A =
        Matrix9::Identity() + 0.1 * Matrix9::NullaryExpr([&](auto, auto) {
                                return std::uniform_real_distribution<double>(-1, 1)(rng);
                              });
    pre.covariance = A * A.transpose();
    const Vector3d p = testing::RandomVector(rng, 1e3);
    const PreintegratedInertial factor(pre, motion.frame, p, p + testing::RandomVector(rng, 60.0),
                                       num_gyro, num_accel, attraction);
    MapPose i{0.0, testing::RandomRotation(rng), p, testing::RandomVector(rng, 60.0)};
    MapPose j{0.0, testing::RandomRotation(rng), p + testing::RandomVector(rng, 60.0),
              testing::RandomVector(rng, 60.0)};
    if (seed % 5 == 0) j.q_mb = i.q_mb * pre.delta_q;  // zero rotation residual
    std::vector<VectorXd> x = States(i, j);
    for (int k = 0; k < num_gyro; ++k) x.push_back(testing::RandomVector(rng, 1e-2));
    for (int k = 0; k < num_accel; ++k) x.push_back(testing::RandomVector(rng, 0.1));
    if (seed % 2 == 1) {
      x.push_back(testing::RandomVector(rng, 0.1));
      x.push_back(testing::RandomVector(rng, 0.1).head<1>());
      x.push_back(testing::RandomVector(rng, 0.1).head<2>());
    }
    testing::ExpectFactorConsistent(factor, x, testing::DynamicAutodiff(factor));
  }
}

// The attitude error is rotated with the body: F = R_j^T C^T R_i, not the identity.
TEST(PreintegratedInertial, AttitudeErrorTurnsWithTheBody) {
  const EarthMotion motion = testing::PlaneMotion();
  const Preintegrated pre = Increments(motion, 3.0, 4.0);
  const std::vector<VectorXd> x = WithBiases(States(motion.Pose(3.0), motion.Pose(4.0)));
  const PreintegratedInertial factor = Factor(motion, pre);
  const Eigen::Matrix3d J_i = Jacobian(factor, x, 0, pre.covariance).topRows<3>();
  const Eigen::Matrix3d J_j = Jacobian(factor, x, 3, pre.covariance).topRows<3>();
  EXPECT_LE((J_j - Eigen::Matrix3d::Identity()).norm(), 1e-6);
  EXPECT_LE((J_i + pre.delta_q.toRotationMatrix().transpose()).norm(), 1e-6);
  EXPECT_GE((J_i + Eigen::Matrix3d::Identity()).norm(), 0.01);
}

// A change of the biases must change the residual as integrating again would.
TEST(PreintegratedInertial, BiasesActAsInTheIncrements) {
  const EarthMotion motion = testing::PlaneMotion();
  const Vector3d b_g(2e-6, -1e-6, 3e-6), b_a(1e-4, 2e-4, -1e-4);
  const Preintegrated at_zero = Increments(motion, 3.0, 4.0);
  const Preintegrated at_bias = Increments(motion, 3.0, 4.0, {b_g, b_a});
  const std::vector<VectorXd> x = WithBiases(States(motion.Pose(3.0), motion.Pose(4.0)), b_g, b_a);
  const Vector9 predicted = EvaluateInertial(Factor(motion, at_zero), x);
  EXPECT_GE(predicted.norm(), 1.0);
  EXPECT_LE((predicted - EvaluateInertial(Factor(motion, at_bias), x)).norm(),
            1e-3 * predicted.norm());

  const PreintegratedInertial split(at_zero, motion.frame, motion.Pose(3.0).p_mb,
                                    motion.Pose(4.0).p_mb, 2, 2);
  std::vector<VectorXd> parts = States(motion.Pose(3.0), motion.Pose(4.0));
  for (const Vector3d& part :
       {Vector3d(0.3 * b_g), Vector3d(0.7 * b_g), Vector3d(0.4 * b_a), Vector3d(0.6 * b_a)}) {
    parts.push_back(part);
  }
  EXPECT_LE((EvaluateInertial(split, parts) - predicted).norm(), 1e-9 * predicted.norm());
}

// Gravitation is evaluated at the states, even far from the nominal positions.
TEST(PreintegratedInertial, NominalPositionsDoNotMatter) {
  const EarthMotion motion = testing::PlaneMotion();
  const Preintegrated pre = Increments(motion, 3.0, 4.0);
  const std::vector<VectorXd> x = WithBiases(States(motion.Pose(3.0), motion.Pose(4.0)));
  const Vector9 near = EvaluateInertial(Factor(motion, pre), x);
  const Vector3d away(600.0, -600.0, 500.0);
  const PreintegratedInertial far(pre, motion.frame, motion.Pose(3.0).p_mb + away,
                                  motion.Pose(4.0).p_mb + away, 1, 1);
  // 1e-6 m/s^2 over one second, in units of 1e-4 m/s.
  EXPECT_LE((EvaluateInertial(far, x) - near).lpNorm<Eigen::Infinity>(), 0.02);
}

// The whitened residual uses the covariance of the increments: W^T W = P^-1.
TEST(PreintegratedInertial, IsWhitenedByTheCovariance) {
  const EarthMotion motion = testing::PlaneMotion();
  const Preintegrated pre = Increments(motion, 3.0, 4.0);
  MapPose j = motion.Pose(4.0);
  const std::vector<VectorXd> at = WithBiases(States(motion.Pose(3.0), j));
  const Vector9 r_0 = EvaluateInertial(Factor(motion, pre), at);
  const Vector3d v(3e-4, -2e-4, 1e-4);
  j.v_m += v;
  const Vector9 r =
      EvaluateInertial(Factor(motion, pre), WithBiases(States(motion.Pose(3.0), j))) - r_0;
  Vector9 e = Vector9::Zero();
  e.segment<3>(3) = motion.Pose(3.0).q_mb.conjugate() * v;
  const double expected = e.dot(pre.covariance.llt().solve(e));
  EXPECT_NEAR(r.squaredNorm(), expected, 1e-3 * expected);  // the Earth rotates by 7e-5 rad
}

/// Returns the information of a chain of edges on (state 0, ..., state n). The tangent order is
/// rotation, position, velocity per node; the biases are constant.
Eigen::MatrixXd Information(const EarthMotion& motion, const std::vector<double>& times,
                            const ImuData& imu, const PreintegrationNoise& noise) {
  const Eigen::Index size = 9 * static_cast<Eigen::Index>(times.size());
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t k = 0; k + 1 < times.size(); ++k) {
    const Preintegrated pre = Preintegrate(imu, times[k], times[k + 1], {}, noise);
    const PreintegratedInertial factor = Factor(motion, pre);
    const auto x = WithBiases(States(motion.Pose(times[k]), motion.Pose(times[k + 1])));
    Eigen::Matrix<double, 9, 18> J;
    for (std::size_t b = 0; b < 6; ++b) {
      J.middleCols<3>(static_cast<Eigen::Index>(3 * b)) =
          pre.covariance.llt().matrixL().solve(Jacobian(factor, x, b, pre.covariance));
    }
    N.block<18, 18>(9 * static_cast<Eigen::Index>(k), 9 * static_cast<Eigen::Index>(k)) +=
        J.transpose() * J;
  }
  return N;
}

// Marginalising the interior nodes of a chain of one-sample edges must give the edge of the
// composed increments. Both must have the same information on the two outer nodes.
TEST(PreintegratedInertial, RawChainIsThePreintegratedEdge) {
  const EarthMotion motion = testing::PlaneMotion();
  const ImuData imu = motion.Measure(0.0, 1.0, 100.0);
  // Large white noise keeps the elimination of the interior nodes well conditioned. The floor is
  // zero, because it would enter once per edge.
  const PreintegrationNoise noise{1e-3, 1e-2, 0.0};
  std::vector<double> times{imu.samples[29].t_s};
  for (int k = 1; k <= 10; ++k) times.push_back(imu.samples[29 + static_cast<std::size_t>(k)].t_s);
  const Eigen::MatrixXd raw = Information(motion, times, imu, noise);
  const Eigen::MatrixXd whole = Information(motion, {times.front(), times.back()}, imu, noise);

  const Eigen::Index inner = raw.rows() - 18;
  Eigen::MatrixXd outer_inner(18, inner), outer(18, 18);
  outer_inner << raw.block(0, 9, 9, inner), raw.block(raw.rows() - 9, 9, 9, inner);
  outer.setZero();
  outer.topLeftCorner<9, 9>() = raw.topLeftCorner<9, 9>();
  outer.bottomRightCorner<9, 9>() = raw.bottomRightCorner<9, 9>();
  const Eigen::MatrixXd marginal =
      outer - outer_inner * raw.block(9, 9, inner, inner).ldlt().solve(outer_inner.transpose());
  const VectorXd scale = whole.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd difference = scale.asDiagonal() * (marginal - whole) * scale.asDiagonal();
  EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-4) << difference.diagonal().transpose();
}

TEST(PreintegratedInertial, RejectsBadInput) {
  const EarthMotion motion = testing::PlaneMotion();
  const Preintegrated pre = Increments(motion, 3.0, 3.1);
  const Vector3d p = motion.Pose(3.0).p_mb;
  const Vector3d nan = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THROW(PreintegratedInertial(pre, motion.frame, nan, p, 1, 1), InvalidInput);
  EXPECT_THROW(PreintegratedInertial(pre, motion.frame, p, nan, 1, 1), InvalidInput);
  EXPECT_THROW(PreintegratedInertial(pre, motion.frame, p, p, -1, 1), InvalidInput);
  EXPECT_THROW(PreintegratedInertial(pre, motion.frame, p, p, 1, -1), InvalidInput);
  Preintegrated singular = pre;
  singular.covariance.setZero();
  try {
    const PreintegratedInertial edge(singular, motion.frame, p, p, 1, 1);
    ADD_FAILURE() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("from t = 3.000000 to 3.100000 s"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("white noise"), std::string::npos);
  }
  Preintegrated empty = pre;
  empty.t_end_s = empty.t_begin_s;
  EXPECT_THROW(PreintegratedInertial(empty, motion.frame, p, p, 1, 1), InvalidInput);
}

}  // namespace dn::factors_test
