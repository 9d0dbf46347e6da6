#include <dn/error.h>
#include <dn/factors/gnss_antenna.h>
#include <dn/factors/gnss_position.h>
#include <dn/factors/gnss_velocity.h>
#include <dn/factors/point_to_point_between_nodes.h>
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "factors/gyro_scale.h"
#include "factors/mounting.h"
#include "testing/earth_motion.h"
#include "testing/factor_consistency.h"
#include "testing/random.h"

namespace dn::factors_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::EarthMotion;
using testing::GyroScale;
using testing::Mounting;
using testing::State;

const PreintegrationNoise kEffectsNoise{0.2 * kRadPerDeg / 60.0, 80e-6 * kStandardGravityMps2,
                                        1e-6};

/// Stretches the laser vector, delays the tag, rotates the boresight and moves the lever arm:
/// everything that a lidar effect can do.
class AllOfLidar final : public LidarEffect {
 public:
  int components() const override { return 3; }
  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    reading->J_u *= 1.0 + value[0];
    reading->J_u.col(column) = reading->u_s;
    reading->u_s *= 1.0 + value[0];
    reading->delay_s += value[1];
    reading->J_delay[column + 1] = 1.0;
    reading->turn_b_rad += value[2] * Vector3d(1.0, -2.0, 0.5);
    reading->J_turn.col(column + 2) = Vector3d(1.0, -2.0, 0.5);
    reading->arm_b_m += value[2] * Vector3d(-0.5, 1.0, 2.0);
    reading->J_arm.col(column + 2) = Vector3d(-0.5, 1.0, 2.0);
  }
};

/// Delays the tag, shifts the position along map x and moves the lever arm along body y.
class LateAndShifted final : public GnssEffect {
 public:
  int components() const override { return 3; }
  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               GnssReading* reading) const override {
    reading->delay_s += value[0];
    reading->J_delay[column] = 1.0;
    reading->shift_m.x() += value[1];
    reading->J_shift(0, column + 1) = 1.0;
    reading->arm_b_m.y() += value[2];
    reading->J_arm(1, column + 2) = 1.0;
  }
};

class PairOfEffects : public ::testing::Test {
 protected:
  const EarthMotion motion_ = testing::PlaneMotion();
  const ImuData imu_ = motion_.Measure(0.0, 6.0, 200.0);
  const std::shared_ptr<const ImuEffect> scale_ = std::make_shared<GyroScale>();

  LidarEnd End(double node_s, double t_s, const Vector3d& u_s) const {
    LidarEnd end;
    end.tag_s = t_s + 0.002;
    end.partial =
        Preintegrate(imu_, node_s, t_s,
                     {Vector3d::Zero(), Vector3d::Zero(), {{scale_, Vector3d(1e-3, 0.0, -2e-3)}}},
                     kEffectsNoise);
    end.u_s = u_s;
    end.p_nominal_m = motion_.Pose(node_s).p_mb;
    return end;
  }
  static PreparedPair Pair(const LidarEnd& i, const LidarEnd& j) {
    return {i, j, Mounting(), 0.002, Noise<3>::Sigma(1.0)};
  }
  PointToPointBetweenNodes Factor() const {
    return {motion_.frame,
            Pair(End(1.0, 1.31, {950.0, 10.0, 300.0}), End(4.0, 4.22, {920.0, 0.0, -250.0})),
            {std::make_shared<AllOfLidar>(), std::make_shared<AllOfLidar>()},
            {Eigen::Matrix<double, 3, 2>::Ones()}};
  }
  std::vector<VectorXd> Blocks(const Vector3d& lidar, const Vector3d& scale) const {
    const MapPose i = motion_.Pose(1.0), j = motion_.Pose(4.0);
    return {State(i.q_mb),
            i.p_mb,
            i.v_m,
            State(j.q_mb),
            j.p_mb,
            j.v_m,
            State(Exp(Vector3d(0.04, -0.02, 0.06))),
            Vector3d(0.14, -0.02, 0.21),
            VectorXd(VectorXd::Constant(1, 1e-3)),
            lidar,
            Vector3d(0.5 * lidar),
            scale,
            VectorXd(VectorXd::Constant(2, 1e-3))};
  }
};

// A factor without effects provides the derivatives of its points with respect to any effect.
TEST_F(PairOfEffects, AreForetoldByTheFactorWithoutThem) {
  const LidarEnd i = End(1.0, 1.31, {950.0, 10.0, 300.0}), j = End(4.0, 4.22, {920.0, 0.0, -250.0});
  const PointToPoint plain(motion_.frame, Pair(i, j));
  const std::vector<VectorXd> blocks = Blocks(Vector3d::Zero(), Vector3d(1e-3, 0.0, -2e-3));
  std::vector<const double*> x;
  for (const VectorXd& block : blocks) x.push_back(block.data());
  const VectorXd no_attraction = VectorXd::Zero(2);
  x.back() = no_attraction.data();

  Eigen::Matrix3Xd foretold = Eigen::Matrix3Xd::Zero(3, 11);
  const LidarEffects lidar{std::make_shared<AllOfLidar>(), std::make_shared<AllOfLidar>()};
  const std::vector<GravitationBasis> attraction{Eigen::Matrix<double, 3, 2>::Ones()};
  const auto add = [&](PointPairFactor::End end, const LidarEnd& from) {
    const LidarReading reading = Corrected(lidar, x.data() + 9, from.tag_s, from.u_s);
    AddEffectJacobians(*plain.SensitivityAt(end, x.data()),
                       {reading, from.partial.J_effects, nullptr, attraction}, Mounting(),
                       foretold);
  };
  add(PointPairFactor::End::kI, i);
  add(PointPairFactor::End::kJ, j);

  const PointToPointBetweenNodes factor = Factor();
  std::vector<double> J_data(3 * 11);
  std::vector<double*> J(13, nullptr);
  double* next = J_data.data();
  for (std::size_t block = 9; block < 13; ++block) {
    J[block] = next;
    next += 3 * blocks[block].size();
  }
  Vector3d r;
  ASSERT_TRUE(factor.Evaluate(x.data(), r.data(), J.data()));
  Eigen::Index column = 0;
  for (std::size_t block = 9; block < 13; ++block) {
    const Eigen::Index size = blocks[block].size();
    const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> J_block(
        J[block], 3, size);
    EXPECT_LT((J_block - foretold.middleCols(column, size)).norm(), 1e-9 * J_block.norm()) << block;
    column += size;
  }
}

TEST_F(PairOfEffects, JacobiansAgreeAtRandomStates) {
  const PointToPointBetweenNodes factor = Factor();
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    std::vector<VectorXd> x =
        Blocks(testing::RandomVector(rng, 0.02), testing::RandomVector(rng, 1e-2));
    if (seed % 2 == 1) x[6] = State(Exp(testing::RandomVector(rng, 1.0)));
    testing::ExpectFactorConsistent(factor, x);
  }
}

// With zero values of its effects the pair equals the plain pair.
TEST_F(PairOfEffects, LeavesThePlainPairWithoutValues) {
  const PointToPointBetweenNodes factor = Factor();
  std::vector<VectorXd> x = Blocks(Vector3d::Zero(), Vector3d(1e-3, 0.0, -2e-3));
  x[12].setZero();
  const PointToPoint plain(motion_.frame, Pair(End(1.0, 1.31, {950.0, 10.0, 300.0}),
                                               End(4.0, 4.22, {920.0, 0.0, -250.0})));
  const std::vector<VectorXd> own(x.begin(), x.begin() + 9);
  const auto [x_i, x_j] = factor.Points(testing::internal::Pointers(x).data());
  const auto [y_i, y_j] = plain.Points(testing::internal::Pointers(own).data());
  EXPECT_LE((x_i - y_i).norm(), 1e-9);
  EXPECT_LE((x_j - y_j).norm(), 1e-9);
}

// The increments must change with the scale as if integrated with it, and the point must move with
// gravitation as Propagate does.
TEST_F(PairOfEffects, IncrementsAndAttractionMoveThePoint) {
  const PointToPointBetweenNodes factor = Factor();
  const Vector3d moved_scale(1.1e-3, 2e-4, -2.2e-3);
  std::vector<VectorXd> x = Blocks(Vector3d::Zero(), moved_scale);
  x[8][0] = 2e-3;  // so that the epoch is the end of the increments
  x[12] = Eigen::Vector2d(3e-3, 1e-3);
  const Preintegrated anew =
      Preintegrate(imu_, 1.0, 1.31, {Vector3d::Zero(), Vector3d::Zero(), {{scale_, moved_scale}}},
                   kEffectsNoise);
  const MapPose end = Propagate(motion_.frame, motion_.Pose(1.0), anew, Vector3d::Constant(4e-3));
  const Eigen::Quaterniond q_boresight(x[6].data());
  const Vector3d l_b = x[7] + q_boresight * (Mounting() * Vector3d(950.0, 10.0, 300.0));
  const Vector3d expected = end.p_mb + end.q_mb * l_b;
  const Vector3d x_i = factor.Points(testing::internal::Pointers(x).data()).first;
  x[11] = Vector3d(1e-3, 0.0, -2e-3);
  x[12].setZero();
  const Vector3d unmoved = factor.Points(testing::internal::Pointers(x).data()).first;
  EXPECT_GE((unmoved - expected).norm(), 2e-3);
  EXPECT_LE((x_i - expected).norm(), 2e-5);
}

TEST_F(PairOfEffects, RejectsEndsWithOtherEffects) {
  LidarEnd plain = End(4.0, 4.2, {900.0, 0.0, 0.0});
  plain.partial = Preintegrate(imu_, 4.0, 4.2, {}, kEffectsNoise);
  EXPECT_THROW(PointToPointBetweenNodes(motion_.frame,
                                        Pair(End(1.0, 1.3, {900.0, 0.0, 0.0}), plain), {}, {}),
               InvalidInput);
}

class Antenna : public ::testing::TestWithParam<GnssAntenna::Quantity> {};

TEST_P(Antenna, JacobiansAgreeAtRandomStates) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const MotionNearTag motion{10.0, testing::RandomVector(rng, 1.0),
                               testing::RandomVector(rng, 1.0), testing::RandomVector(rng, 5.0)};
    const GnssAntenna factor(GetParam(), testing::RandomVector(rng, 60.0), motion,
                             {std::make_shared<LateAndShifted>()}, Noise<3>::Sigma(0.5));
    const std::vector<VectorXd> x{State(testing::RandomRotation(rng)),
                                  testing::RandomVector(rng, 60.0), testing::RandomVector(rng, 2.0),
                                  testing::RandomVector(rng, 60.0),
                                  VectorXd(testing::RandomVector(rng, 0.3))};
    testing::ExpectFactorConsistent(factor, x);
  }
}

INSTANTIATE_TEST_SUITE_P(GnssAntenna, Antenna,
                         ::testing::Values(GnssAntenna::Quantity::kPosition,
                                           GnssAntenna::Quantity::kVelocity),
                         [](const auto& tested) {
                           return tested.param == GnssAntenna::Quantity::kPosition ? "position"
                                                                                   : "velocity";
                         });

// On an analytic flight the antenna position at tag - delay is correct to third order.
TEST(GnssAntenna, FollowsTheAntennaToALateTag) {
  const EarthMotion flight = testing::PlaneMotion();
  const ImuData imu = flight.Measure(0.0, 4.0, 200.0);
  const Vector3d lever_b(1.0, -2.0, -3.0), assumed_b(1.0, -2.2, -3.0), w_ie = flight.frame.w_ie_m();
  const double tag_s = imu.samples[499].t_s, delay_s = 0.01;
  const MapPose at = flight.Pose(tag_s), then = flight.Pose(tag_s - delay_s);
  const Preintegrated here = IdentityIncrement(imu, tag_s, {});
  const Vector3d a_m =
      at.q_mb * here.f_end_b_mps2 + flight.frame.Gravity(at.p_mb) - 2.0 * w_ie.cross(at.v_m);
  const MotionNearTag motion{tag_s, here.w_end_b_radps, w_ie, a_m};
  const VectorXd late = Vector3d(delay_s, 0.25, 0.2);
  const std::vector<VectorXd> x{State(at.q_mb), at.p_mb, assumed_b, at.v_m, late};
  const auto residual = [&](GnssAntenna::Quantity quantity, const Vector3d& z_m) {
    const GnssAntenna factor(quantity, z_m, motion, {std::make_shared<LateAndShifted>()},
                             Noise<3>::Sigma(1.0));
    Vector3d r;
    EXPECT_TRUE(factor.Evaluate(testing::internal::Pointers(x).data(), r.data(), nullptr));
    return r;
  };
  const Vector3d z_m = then.p_mb + then.q_mb * lever_b + Vector3d(0.25, 0.0, 0.0);
  // d w / dt times the lever arm.
  EXPECT_LE(residual(GnssAntenna::Quantity::kPosition, z_m).norm(), 6e-5);
  const Vector3d w_eb = flight.AngularRate(tag_s - delay_s) - then.q_mb.conjugate() * w_ie;
  const Vector3d v_m = then.v_m + then.q_mb * w_eb.cross(lever_b);
  // d w / dt times the lever arm.
  EXPECT_LE(residual(GnssAntenna::Quantity::kVelocity, v_m).norm(), 1e-2);
}

TEST(GnssAntenna, RejectsBadInput) {
  const Vector3d zero = Vector3d::Zero();
  const Vector3d nan = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  const auto make = [](const Vector3d& z_m, const Vector3d& w, const Vector3d& a) {
    return GnssAntenna(GnssAntenna::Quantity::kPosition, z_m, {0.0, w, Vector3d::Zero(), a}, {},
                       Noise<3>::Sigma(1.0));
  };
  EXPECT_NO_THROW(make(zero, zero, zero));
  EXPECT_THROW(make(nan, zero, zero), InvalidInput);
  EXPECT_THROW(make(zero, nan, zero), InvalidInput);
  EXPECT_THROW(make(zero, zero, nan), InvalidInput);
}

}  // namespace dn::factors_test
