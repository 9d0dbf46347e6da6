#include <dn/error.h>
#include <dn/factors/point_to_point.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "factors/mounting.h"
#include "testing/earth_motion.h"
#include "testing/factor_consistency.h"
#include "testing/random.h"

namespace dn::factors_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::EarthMotion;
using testing::Mounting;
using testing::State;

const PreintegrationNoise kNoise{0.2 * kRadPerDeg / 60.0, 80e-6 * kStandardGravityMps2, 1e-6};
const Eigen::Quaterniond kBoresight = Exp(Vector3d(0.004, -0.002, 0.006));
const Vector3d kLeverArm(0.14, -0.02, 0.21);

/// Returns one end that observes `point` at t_s from the node at node_s (not after t_s).
LidarEnd See(const EarthMotion& motion, const ImuData& imu, double node_s, double t_s,
             const Vector3d& point) {
  const MapPose pose = motion.Pose(t_s);
  const Vector3d u_b = pose.q_mb.conjugate() * Vector3d(point - pose.p_mb) - kLeverArm;
  LidarEnd end;
  end.partial =
      node_s == t_s ? IdentityIncrement(imu, t_s, {}) : Preintegrate(imu, node_s, t_s, {}, kNoise);
  end.u_s = Mounting().transpose() * (kBoresight.conjugate() * u_b);
  end.p_nominal_m = motion.Pose(node_s).p_mb;
  return end;
}

std::vector<VectorXd> States(const MapPose& i, const MapPose& j, double dt_s) {
  return {State(i.q_mb),     i.p_mb,    i.v_m,
          State(j.q_mb),     j.p_mb,    j.v_m,
          State(kBoresight), kLeverArm, VectorXd(VectorXd::Constant(1, dt_s))};
}

Vector3d EvaluateResidual(const FactorBase& factor, const std::vector<VectorXd>& x) {
  std::vector<const double*> pointers;
  for (const VectorXd& block : x) pointers.push_back(block.data());
  Vector3d r;
  EXPECT_TRUE(factor.Evaluate(pointers.data(), r.data(), nullptr));
  return r;
}

/// Two observations of one ground point from an analytic flight.
class PointPair : public ::testing::Test {
 protected:
  const EarthMotion motion_ = testing::PlaneMotion();
  const ImuData imu_ = motion_.Measure(0.0, 6.0, 200.0);
  const Vector3d point_ = motion_.Pose(3.0).p_mb + Vector3d(120.0, -200.0, -950.0);

  PointToPoint Factor(double node_i_s, double t_i_s, double node_j_s, double t_j_s,
                      double dt_nominal_s = 0.0) const {
    return {
        motion_.frame,
        {See(motion_, imu_, node_i_s, t_i_s, point_), See(motion_, imu_, node_j_s, t_j_s, point_),
         Mounting(), dt_nominal_s, Noise<3>::Sigma(1.0)}};
  }
  std::vector<VectorXd> Truth(double node_i_s, double node_j_s, double dt_s = 0.0) const {
    return States(motion_.Pose(node_i_s), motion_.Pose(node_j_s), dt_s);
  }
};

TEST_F(PointPair, VanishesOnAnAnalyticFlight) {
  for (const double node_s : {1.0, 1.2, 1.4, 1.45}) {
    SCOPED_TRACE("node " + std::to_string(node_s));
    const Vector3d r = EvaluateResidual(Factor(node_s, 1.4537, 4.0, 4.9012), Truth(node_s, 4.0));
    EXPECT_LE(r.norm(), 5e-6);  // 2e-9 rad at 1 km, and gravitation linearised over 0.9 s
  }
}

// The result does not depend on whether the node is at the epoch or before it.
TEST_F(PointPair, PartialIncrementsAgreeWithANodeAtTheEpoch) {
  const double t_s = imu_.samples[299].t_s;
  const Vector3d at_node = EvaluateResidual(Factor(t_s, t_s, 4.0, 4.1), Truth(t_s, 4.0));
  const Vector3d before = EvaluateResidual(Factor(1.3, t_s, 4.0, 4.1), Truth(1.3, 4.0));
  EXPECT_LE((before - at_node).norm(), 5e-6);
}

// Hand calculation: identity attitudes and increments; sensor, body and map axes coincide.
TEST(PointToPoint, ResidualOfAShiftedPair) {
  LidarEnd i, j;
  i.u_s = {1.0, 2.0, 100.0};
  j.u_s = {1.0, -2.0, 100.0};
  const PointToPoint factor(LocalFrame({0.8, 0.1, 0.0}),
                            {i, j, Matrix3d::Identity(), 0.0, Noise<3>::Sigma(0.5)});
  MapPose a, b;
  a.p_mb = {10.0, 20.0, 30.0};
  b.p_mb = {10.0, 24.0, 31.0};
  std::vector<VectorXd> x = States(a, b, 0.0);
  x[6] = State(Eigen::Quaterniond::Identity());
  EXPECT_LE((EvaluateResidual(factor, x) - Vector3d(0.0, 0.0, -2.0)).norm(), 1e-10);
}

TEST_F(PointPair, JacobiansAgreeAtRandomStates) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> part(0.0, 0.5);
    const bool on_node = seed % 5 == 0;
    const PointToPoint factor =
        Factor(1.0, on_node ? 1.0 : 1.001 + part(rng), 4.0, 4.001 + part(rng), 2e-3);
    std::vector<VectorXd> x = Truth(1.0, 4.0, 2e-3 + 0.05 * part(rng));
    if (seed % 2 == 1) {
      for (const std::size_t q : {0, 3, 6}) x[q] = State(testing::RandomRotation(rng));
      x[7] = testing::RandomVector(rng, 1.0);
    }
    if (seed == 4) x[7].setZero();
    testing::ExpectFactorConsistent(factor, x, testing::Autodiff(factor));
  }
}

// For a tag that is late by dt, ending the increments dt earlier must equal shifting the point by
// -dt.
TEST_F(PointPair, TimeOffsetMovesThePointAlongItsPath) {
  constexpr double kOffset_s = 1e-3;
  const LidarEnd true_i = See(motion_, imu_, 1.0, 1.3, point_);
  const LidarEnd true_j = See(motion_, imu_, 4.0, 4.2, point_);
  LidarEnd late_i = true_i, late_j = true_j;
  late_i.partial = Preintegrate(imu_, 1.0, 1.3 + kOffset_s, {}, kNoise);
  late_j.partial = Preintegrate(imu_, 4.0, 4.2 + kOffset_s, {}, kNoise);
  const PointToPoint late(motion_.frame, {late_i, late_j, Mounting(), 0.0, Noise<3>::Sigma(1.0)});
  const double ignored = EvaluateResidual(late, Truth(1.0, 4.0, 0.0)).norm();
  EXPECT_GE(ignored, 1e-3);
  // Second-order error: 0.1 rad/s^2 x 1 km x dt^2 / 2.
  EXPECT_LE(EvaluateResidual(late, Truth(1.0, 4.0, kOffset_s)).norm(), 2e-4);
}

// A common translation of both nodes at unchanged velocities must change the residual only through
// the rotation of the Earth and gravitation.
TEST_F(PointPair, CommonTranslationCancels) {
  const PointToPoint factor = Factor(1.0, 1.3, 4.0, 4.2);
  std::vector<VectorXd> x = Truth(1.0, 4.0);
  const Vector3d before = EvaluateResidual(factor, x);
  x[1] += Vector3d(5.0, -3.0, 2.0);
  x[4] += Vector3d(5.0, -3.0, 2.0);
  EXPECT_LE((EvaluateResidual(factor, x) - before).norm(), 1e-6);
}

TEST_F(PointPair, PointsAreTheGroundPoint) {
  const PointToPoint factor = Factor(1.0, 1.3, 4.0, 4.2);
  const std::vector<VectorXd> x = Truth(1.0, 4.0);
  std::vector<const double*> pointers;
  for (const VectorXd& block : x) pointers.push_back(block.data());
  const auto [x_i, x_j] = factor.Points(pointers.data());
  EXPECT_LE((x_i - point_).norm(), 5e-6);
  EXPECT_LE((x_j - point_).norm(), 5e-6);
}

// Compares white noise on the samples with EndNoise: 2000 runs give a 1.6 % sigma of a variance;
// the bound is four times that.
TEST_F(PointPair, EndNoiseIsThatOfMonteCarlo) {
  constexpr int kRuns = 2000;
  const double node_s = 1.0, t_s = 1.3;
  const ImuData imu = motion_.Measure(0.5, 2.0, 200.0);
  const LidarEnd end = See(motion_, imu, node_s, t_s, point_);
  const Matrix3d R_mb = motion_.Attitude(node_s).toRotationMatrix();
  const Vector3d l_b = kLeverArm + kBoresight * (Mounting() * end.u_s);
  const Matrix3d expected = EndNoise(end, R_mb, l_b);
  std::mt19937 rng(11);
  std::normal_distribution<double> normal;
  Matrix3d sum = Matrix3d::Zero();
  const MapPose start = motion_.Pose(node_s);
  for (int run = 0; run < kRuns; ++run) {
    ImuData noisy = imu;
    for (ImuSample& sample : noisy.samples) {
      const double root = std::sqrt(sample.dt_s);
      for (int k = 0; k < 3; ++k) {
        sample.w_ib_b_radps[k] += kNoise.gyro_white_rad_per_sqrt_s / root * normal(rng);
        sample.f_b_mps2[k] += kNoise.accel_white_mps_per_sqrt_s / root * normal(rng);
      }
    }
    const MapPose pose =
        Propagate(motion_.frame, start, Preintegrate(noisy, node_s, t_s, {}, kNoise));
    const Vector3d e = pose.p_mb + pose.q_mb * l_b - point_;
    sum += e * e.transpose();
  }
  const Vector3d sigma = expected.diagonal().cwiseSqrt();
  const Matrix3d difference = sigma.cwiseInverse().asDiagonal() * (sum / kRuns - expected) *
                              sigma.cwiseInverse().asDiagonal();
  EXPECT_LE(difference.cwiseAbs().maxCoeff(), 4.0 * std::sqrt(2.0 / kRuns)) << difference;
  EXPECT_TRUE(EndNoise(See(motion_, imu, node_s, node_s, point_), R_mb, l_b).isZero(0.0));
}

TEST_F(PointPair, RejectsBadInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const LidarEnd good = See(motion_, imu_, 1.0, 1.3, point_);
  const auto make = [&](const LidarEnd& i, const LidarEnd& j, const Matrix3d& R_bs, double dt_s) {
    return PointToPoint(motion_.frame, {i, j, R_bs, dt_s, Noise<3>::Sigma(0.1)});
  };
  EXPECT_NO_THROW(make(good, good, Mounting(), 0.0));
  LidarEnd bad = good;
  bad.u_s.setZero();
  EXPECT_THROW(make(bad, good, Mounting(), 0.0), InvalidInput);
  EXPECT_THROW(make(good, bad, Mounting(), 0.0), InvalidInput);
  bad.u_s = {nan, 0.0, 1.0};
  EXPECT_THROW(make(bad, good, Mounting(), 0.0), InvalidInput);
  bad = good;
  bad.p_nominal_m.x() = nan;
  EXPECT_THROW(make(good, bad, Mounting(), 0.0), InvalidInput);
  EXPECT_THROW(make(good, good, 1.01 * Mounting(), 0.0), InvalidInput);
  EXPECT_THROW(make(good, good, -Mounting(), 0.0), InvalidInput);
  EXPECT_THROW(make(good, good, Mounting(), nan), InvalidInput);
}

}  // namespace dn::factors_test
