#include <dn/imu/strapdown.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "testing/earth_motion.h"
#include "testing/random.h"

namespace dn::imu_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::EarthMotion;

const PreintegrationNoise kSmallNoise{1e-6, 1e-4, 1e-6};

LocalFrame Alps() { return LocalFrame({46.5 * kRadPerDeg, 6.5 * kRadPerDeg, 500.0}); }

// The terms in brackets are compared with long double arithmetic on the whole position vector.
TEST(EarthStep, BracketsAreFreeOfCancellation) {
  const LocalFrame frame = Alps();
  using Vector = Eigen::Matrix<long double, 3, 1>;
  for (const double dt : {1e-3, 0.1, 1.0, 100.0, 3600.0, 20000.0}) {
    SCOPED_TRACE("dt " + std::to_string(dt));
    const EarthStep step = EarthStep::Make(frame, dt);
    const Vector w = frame.w_ie_m().cast<long double>(), r0 = frame.r0_m().cast<long double>();
    const long double rate = w.norm(), angle = rate * dt;
    const Vector axis = w / rate;
    const auto turn = [&](const Vector& x) {  // (C - I) x, with 1 - cos by the half angle
      const long double s = std::sin(0.5L * angle);
      return Vector(std::sin(angle) * axis.cross(x) +
                    2.0L * s * s * axis.cross(Vector(axis.cross(x))));
    };
    const Vector position = turn(r0) - w.cross(r0) * static_cast<long double>(dt);
    const Vector velocity = turn(w.cross(r0));
    // The long double result has an error of 1e-19 of w x r0 dt.
    const double floor_m = 1e-18 * 500.0 * dt;
    EXPECT_LE((step.origin_position_m - position.cast<double>()).norm(),
              1e-14 * step.origin_position_m.norm() + floor_m);
    EXPECT_LE((step.origin_velocity_mps - velocity.cast<double>()).norm(),
              1e-14 * step.origin_velocity_mps.norm());
    EXPECT_LE((step.C - Exp(Vector3d(frame.w_ie_m() * dt)).toRotationMatrix()).norm(), 1e-15 * 4);
  }
}

TEST(EarthStep, ForthAndBackIsTheIdentity) {
  const EarthStep forth = EarthStep::Make(Alps(), 7.0), back = EarthStep::Make(Alps(), -7.0);
  EXPECT_LE((forth.C * back.C - Matrix3d::Identity()).norm(), 1e-15);
}

// A point mass has the gradient GM/r^3 (3 e e^T - I). The flattening changes it (J2: 3 J2 = 0.3 %,
// times 4).
TEST(GravitationGradient, IsNearlyThatOfAPointMass) {
  const LocalFrame frame = Alps();
  const Vector3d p(1000.0, -2000.0, 1500.0);
  const Vector3d rho = frame.r0_m() + p;
  const double scale = 3.986004418e14 / std::pow(rho.norm(), 3);
  const Vector3d e = rho.normalized();
  const Matrix3d expected = scale * (3.0 * e * e.transpose() - Matrix3d::Identity());
  EXPECT_LE((GravitationGradient(frame, p) - expected).norm(), 0.015 * expected.norm());
}

Preintegrated Integrated(const EarthMotion& motion, double t0_s, double t1_s) {
  return Preintegrate(motion.Measure(t0_s - 0.05, t1_s + 0.05, 200.0), t0_s, t1_s, {}, kSmallNoise);
}

// Coriolis force, centrifugal force and gravity enter the simulation in another form than the
// propagation. Two errors remain. One is from the parts of samples at the ends (1e-7 m/s). The
// other is from gravitation taken linear in time at an acceleration a: gradient a dt^3 / 12
// (3e-6 x 3 m/s^2).
TEST(Propagate, FollowsAnAnalyticFlight) {
  const EarthMotion motion = testing::PlaneMotion();
  for (const double length_s : {0.013, 0.1, 1.0, 2.0}) {
    SCOPED_TRACE("length " + std::to_string(length_s));
    const double t0_s = 12.0031;
    const MapPose end =
        Propagate(motion.frame, motion.Pose(t0_s), Integrated(motion, t0_s, t0_s + length_s));
    const MapPose truth = motion.Pose(t0_s + length_s);
    EXPECT_DOUBLE_EQ(end.t_s, truth.t_s);
    EXPECT_LE(end.q_mb.angularDistance(truth.q_mb), 2e-9);
    EXPECT_LE((end.v_m - truth.v_m).norm(), 1e-7 + 1e-6 * std::pow(length_s, 3));
    EXPECT_LE((end.p_mb - truth.p_mb).norm(), 1e-9 + 1e-6 * std::pow(length_s, 4));
  }
}

/// Returns the data of a body at rest on the Earth, over one second.
ImuData Still(const LocalFrame& frame, const Eigen::Quaterniond& q_mb, const Vector3d& p) {
  ImuData imu;
  imu.nominal_dt_s = 0.02;
  for (int i = 1; i <= 50; ++i) {
    imu.samples.push_back({0.02 * i, 0.02, q_mb.conjugate() * frame.w_ie_m(),
                           q_mb.conjugate() * Vector3d(-frame.Gravity(p))});
  }
  return imu;
}

// The steps are 0.02 s. Gravitation taken linear in time has an error of g (w dt)^2 / 12, because
// its direction rotates. The vertical channel amplifies an error 270 times within the hour.
TEST(Propagate, StillBodyStaysForAnHour) {
  const LocalFrame frame = Alps();
  const Eigen::Quaterniond q_mb = QuaternionFromRollPitchHeading({0.3, -0.2, 2.0});
  const Vector3d p(5000.0, 3000.0, 200.0);
  const Preintegrated sample = Preintegrate(Still(frame, q_mb, p), 0.5, 0.52, {}, kSmallNoise);
  MapPose pose{0.0, q_mb, p, Vector3d::Zero()};
  for (int i = 0; i < 180000; ++i) pose = Propagate(frame, pose, sample);
  EXPECT_LE((pose.p_mb - p).norm(), 1e-3);
  EXPECT_LE(pose.v_m.norm(), 1e-5);
  EXPECT_LE(pose.q_mb.angularDistance(q_mb), 1e-10);
}

// This is the counterpart: without the Earth's rotation the same data lead kilometres away.
TEST(Propagate, StillBodyLeavesWithoutTheEarthRate) {
  const LocalFrame frame = Alps();
  const Vector3d p(5000.0, 3000.0, 200.0);
  const Preintegrated second =
      Preintegrate(Still(frame, Eigen::Quaterniond::Identity(), p), 0.0, 1.0, {}, kSmallNoise);
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Vector3d v = Vector3d::Zero(), moved = Vector3d::Zero();
  for (int i = 0; i < 3600; ++i) {
    moved += v + 0.5 * frame.Gravity(p) + q * second.delta_p;
    v += frame.Gravity(p) + q * second.delta_v;
    q = (q * second.delta_q).normalized();
  }
  EXPECT_GE(moved.norm(), 1e3);
}

// Without Earth terms, the errors of attitude, velocity and position after one second are 130, 88
// and 76 sigmas of a navigation-grade sensor. The exact form stays below a hundredth of a sigma.
TEST(Propagate, EarthTermsAreNeverOptional) {
  const EarthMotion motion = testing::PlaneMotion();
  const PreintegrationNoise nav{0.002 * kRadPerDeg / 60.0, 10e-6 * kStandardGravityMps2, 0.0};
  const Preintegrated pre = Preintegrate(motion.Measure(4.95, 6.05, 200.0), 5.0, 6.0, {}, nav);
  const Eigen::Matrix<double, 9, 1> sigma = pre.covariance.diagonal().cwiseSqrt();
  const MapPose start = motion.Pose(5.0), truth = motion.Pose(6.0);
  const auto sigmas = [&](const MapPose& end) {
    const Vector3d rotation = Log(Eigen::Quaterniond(end.q_mb.conjugate() * truth.q_mb));
    return Vector3d(rotation.norm() / sigma[0], (end.v_m - truth.v_m).norm() / sigma[3],
                    (end.p_mb - truth.p_mb).norm() / sigma[6]);
  };
  const Vector3d exact = sigmas(Propagate(motion.frame, start, pre));
  EXPECT_LE(exact.maxCoeff(), 0.01) << exact.transpose();

  const Vector3d g = motion.frame.Gravity(start.p_mb);
  const MapPose plain{6.0, start.q_mb * pre.delta_q,
                      start.p_mb + start.v_m + 0.5 * g + start.q_mb * pre.delta_p,
                      start.v_m + g + start.q_mb * pre.delta_v};
  const Vector3d without = sigmas(plain);
  EXPECT_GE(without[0], 100.0);
  EXPECT_GE(without[1], 50.0);
  EXPECT_GE(without[2], 50.0);
}

TEST(Propagate, ComposesOverASplit) {
  const EarthMotion motion = testing::VibratingMotion();
  const ImuData imu = motion.Measure(0.0, 2.0, 200.0);
  const MapPose start = motion.Pose(0.5);
  const MapPose whole =
      Propagate(motion.frame, start, Preintegrate(imu, 0.5, 1.5, {}, kSmallNoise));
  const MapPose half =
      Propagate(motion.frame, start, Preintegrate(imu, 0.5, 0.9983, {}, kSmallNoise));
  const MapPose parts =
      Propagate(motion.frame, half, Preintegrate(imu, 0.9983, 1.5, {}, kSmallNoise));
  EXPECT_LE(parts.q_mb.angularDistance(whole.q_mb), 1e-9);
  EXPECT_LE((parts.v_m - whole.v_m).norm(), 1e-6);  // gravitation linear in time over 1 s or 0.5 s
  EXPECT_LE((parts.p_mb - whole.p_mb).norm(), 1e-6);
}

TEST(AffineStep, AgreesWithPropagate) {
  const EarthMotion motion = testing::PlaneMotion();
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const double length_s = std::uniform_real_distribution<double>(0.01, 1.0)(rng);
    const Preintegrated pre = Integrated(motion, 7.0, 7.0 + length_s);
    const Vector3d p = testing::RandomVector(rng, 2e4);
    const Vector3d nominal = p + testing::RandomVector(rng, 500.0);
    const MapPose start{7.0, testing::RandomRotation(rng), p, testing::RandomVector(rng, 100.0)};
    const AffineStep step = AffineStep::Make(motion.frame, length_s, nominal);
    const Vector3d R_dp = start.q_mb * pre.delta_p, R_dv = start.q_mb * pre.delta_v;
    const MapPose end = Propagate(motion.frame, start, pre);
    const double curvature = 1e-6 * length_s;  // m/s^2 x s within 1 km
    EXPECT_LE((step.p_p * p + step.p_v * start.v_m + step.p_d * R_dp + step.p_0 - end.p_mb).norm(),
              1e-10 + 0.5 * curvature * length_s);
    EXPECT_LE((step.v_p * p + step.v_v * start.v_m + step.C.transpose() * R_dv + step.v_d * R_dp +
               step.v_0 - end.v_m)
                  .norm(),
              1e-10 + curvature);
  }
}

TEST(AffineStep, ZeroLengthIsTheIdentity) {
  const AffineStep step = AffineStep::Make(Alps(), 0.0, {1000.0, 2000.0, 3000.0});
  EXPECT_LE((step.p_p - Matrix3d::Identity()).norm(), 1e-15);
  EXPECT_LE((step.v_v - Matrix3d::Identity()).norm(), 1e-15);
  EXPECT_LE(step.p_v.norm() + step.v_p.norm() + step.p_0.norm() + step.v_0.norm(), 1e-15);
}

}  // namespace dn::imu_test
