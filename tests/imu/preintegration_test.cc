#include <dn/error.h>
#include <dn/imu/preintegration.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "testing/earth_motion.h"
#include "testing/random.h"

namespace dn::imu_test {

using Eigen::Vector3d;
using testing::EarthMotion;

/// Noise of a navigation-grade sensor; integration errors are compared with it.
constexpr double kArw = 0.002 * kRadPerDeg / 60.0;  // rad/sqrt(s)
constexpr double kVrw = 10e-6 * kStandardGravityMps2;
const PreintegrationNoise kNoise{kArw, kVrw, 0.0};

struct Increments {
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Vector3d v = Vector3d::Zero(), p = Vector3d::Zero();
};

Increments operator+(const Increments& x, const Increments& d) {
  return {Eigen::Quaterniond(x.q.coeffs() + d.q.coeffs()), x.v + d.v, x.p + d.p};
}
Increments operator*(double k, const Increments& d) {
  return {Eigen::Quaterniond(k * d.q.coeffs()), k * d.v, k * d.p};
}

Increments Derivative(const EarthMotion& motion, double t_s, const Increments& x) {
  const Vector3d w = 0.5 * motion.AngularRate(t_s);
  return {x.q * Eigen::Quaterniond(0.0, w.x(), w.y(), w.z()), x.q * motion.SpecificForce(t_s), x.v};
}

/// Integrates the continuous measurements with the classical Runge-Kutta method.
Increments RungeKutta(const EarthMotion& motion, double t0_s, double t1_s, int steps) {
  Increments x;
  const double h = (t1_s - t0_s) / steps;
  for (int i = 0; i < steps; ++i) {
    const double t = t0_s + i * h;
    const Increments k1 = Derivative(motion, t, x);
    const Increments k2 = Derivative(motion, t + 0.5 * h, x + 0.5 * h * k1);
    const Increments k3 = Derivative(motion, t + 0.5 * h, x + 0.5 * h * k2);
    const Increments k4 = Derivative(motion, t + h, x + h * k3);
    x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    x.q.normalize();
  }
  return x;
}

struct Sigmas {
  double rotation, velocity, position;
};

/// Returns the largest component of the difference of increments, in standard deviations of
/// `noise`.
Sigmas InSigmas(const Preintegrated& noise, const Eigen::Quaterniond& q, const Vector3d& v,
                const Vector3d& p) {
  const Eigen::Matrix<double, 9, 1> sigma = noise.covariance.diagonal().cwiseSqrt();
  const Vector3d rotation = Log(Eigen::Quaterniond(noise.delta_q.conjugate() * q));
  return {rotation.cwiseQuotient(sigma.head<3>()).lpNorm<Eigen::Infinity>(),
          (v - noise.delta_v).cwiseQuotient(sigma.segment<3>(3)).lpNorm<Eigen::Infinity>(),
          (p - noise.delta_p).cwiseQuotient(sigma.tail<3>()).lpNorm<Eigen::Infinity>()};
}

/// Returns the largest error of 20 intervals of the given length, relative to Runge-Kutta.
Sigmas WorstError(const EarthMotion& motion, double rate_hz, double length_s) {
  const ImuData imu = motion.Measure(0.0, 4.0 + length_s, rate_hz);
  Sigmas worst{0.0, 0.0, 0.0};
  for (int i = 0; i < 20; ++i) {
    const double t0_s = 0.2 * i + 2.0 / rate_hz;
    const Preintegrated pre = Preintegrate(imu, t0_s, t0_s + length_s, {}, kNoise);
    const Increments truth =
        RungeKutta(motion, t0_s, t0_s + length_s, static_cast<int>(4000 * length_s));
    const Sigmas error = InSigmas(pre, truth.q, truth.v, truth.p);
    worst.rotation = std::max(worst.rotation, error.rotation);
    worst.velocity = std::max(worst.velocity, error.velocity);
    worst.position = std::max(worst.position, error.position);
  }
  return worst;
}

void ExpectBelow(const Sigmas& worst, const Sigmas& bound) {
  EXPECT_LE(worst.rotation, bound.rotation);
  EXPECT_LE(worst.velocity, bound.velocity);
  EXPECT_LE(worst.position, bound.position);
}

// The limits are in sigmas of a navigation-grade sensor. An algorithm whose coning and sculling
// terms use only the previous sample reaches 0.001, 0.003, 0.015 in a second.
TEST(Preintegrate, QuietFlightAgreesWithRungeKutta) {
  ExpectBelow(WorstError(testing::PlaneMotion(), 200.0, 0.1), {0.001, 0.001, 0.005});
  ExpectBelow(WorstError(testing::PlaneMotion(), 200.0, 1.0), {0.001, 0.002, 0.014});
}

// The algorithm with only the previous sample reaches 0.06, 0.06, 0.07 at 200 Hz. After 0.1 s, half
// a period of the vibration, the position is wrong by 2e-7 m; this error does not accumulate.
TEST(Preintegrate, VibrationAgreesWithRungeKutta) {
  ExpectBelow(WorstError(testing::VibratingMotion(), 200.0, 0.1), {0.01, 0.01, 0.15});
  ExpectBelow(WorstError(testing::VibratingMotion(), 200.0, 1.0), {0.02, 0.02, 0.02});
  ExpectBelow(WorstError(testing::VibratingMotion(), 500.0, 1.0), {0.002, 0.002, 0.004});
}

void ExpectSame(const Preintegrated& a, const Preintegrated& b, double tolerance) {
  EXPECT_EQ(a.t_begin_s, b.t_begin_s);
  EXPECT_EQ(a.t_end_s, b.t_end_s);
  EXPECT_LE(a.delta_q.angularDistance(b.delta_q), tolerance);
  EXPECT_LE((a.delta_v - b.delta_v).norm(), tolerance);
  EXPECT_LE((a.delta_p - b.delta_p).norm(), tolerance);
  EXPECT_LE((a.w_end_b_radps - b.w_end_b_radps).norm(), tolerance);
  EXPECT_LE((a.f_end_b_mps2 - b.f_end_b_mps2).norm(), tolerance);
}

void ExpectNear(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b, double relative,
                const char* what) {
  EXPECT_LE((a - b).norm(), relative * b.norm()) << what << "\n" << a << "\n\n" << b;
}

void ExpectSameJacobians(const Preintegrated& a, const Preintegrated& b, double relative) {
  ExpectNear(a.J_q_bg, b.J_q_bg, relative, "J_q_bg");
  ExpectNear(a.J_v_bg, b.J_v_bg, relative, "J_v_bg");
  ExpectNear(a.J_v_ba, b.J_v_ba, relative, "J_v_ba");
  ExpectNear(a.J_p_bg, b.J_p_bg, relative, "J_p_bg");
  ExpectNear(a.J_p_ba, b.J_p_ba, relative, "J_p_ba");
}

// The parts of an interval compose to the whole wherever it is split: at a sample, inside one,
// within the first and the last. Inside a sample the third order of the Magnus expansion remains as
// error.
TEST(Preintegrate, PartsComposeToTheWhole) {
  const ImuData imu = testing::VibratingMotion().Measure(0.0, 2.0, 200.0);
  const double begin_s = 0.5012, end_s = 1.4037;
  const Preintegrated whole = Preintegrate(imu, begin_s, end_s, {}, kNoise);
  for (const double split_s : {1.0, 0.5031, 0.50121, 0.9987, 1.0025, 1.4, 1.4036}) {
    SCOPED_TRACE("split at " + std::to_string(split_s));
    const Preintegrated composed = Compose(Preintegrate(imu, begin_s, split_s, {}, kNoise),
                                           Preintegrate(imu, split_s, end_s, {}, kNoise));
    ExpectSame(composed, whole, 1e-9);
    ExpectSameJacobians(composed, whole, 1e-5);
    const Eigen::Matrix<double, 9, 1> sigma = whole.covariance.diagonal().cwiseSqrt();
    const Eigen::Matrix<double, 9, 9> difference = sigma.cwiseInverse().asDiagonal() *
                                                   (composed.covariance - whole.covariance) *
                                                   sigma.cwiseInverse().asDiagonal();
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-6);
  }
}

// A split at a sample epoch involves no approximation.
TEST(Preintegrate, SplitAtASampleIsExact) {
  const ImuData imu = testing::VibratingMotion().Measure(0.0, 2.0, 200.0);
  const double split_s = imu.samples[199].t_s, end_s = imu.samples[299].t_s;
  const Preintegrated whole = Preintegrate(imu, 0.0, end_s, {}, kNoise);
  ExpectSame(Compose(Preintegrate(imu, 0.0, split_s, {}, kNoise),
                     Preintegrate(imu, split_s, end_s, {}, kNoise)),
             whole, 1e-13);
}

// Hand-computed values for a constant specific force without rotation.
TEST(Preintegrate, ConstantForce) {
  ImuData imu;
  imu.nominal_dt_s = 0.01;
  for (int i = 1; i <= 100; ++i) imu.samples.push_back({0.01 * i, 0.01, {0, 0, 0}, {1, 2, -3}});
  const Preintegrated pre = Preintegrate(imu, 0.205, 0.705, {}, {2e-3, 3e-3, 1e-6});
  EXPECT_LE(pre.delta_q.angularDistance(Eigen::Quaterniond::Identity()), 1e-15);
  EXPECT_LE((pre.delta_v - Vector3d(0.5, 1.0, -1.5)).norm(), 1e-12);
  EXPECT_LE((pre.delta_p - Vector3d(0.125, 0.25, -0.375)).norm(), 1e-12);
  EXPECT_NEAR(pre.covariance(0, 0), 4e-6 * 0.5, 1e-15);
  // The variance of velocity x has its own noise and the rotation noise perpendicular to the force,
  // q |f_perp|^2 dt^3 / 3.
  EXPECT_NEAR(pre.covariance(3, 3), 9e-6 * 0.5 + 4e-6 * 13.0 * 0.125 / 3.0, 1e-12);
  EXPECT_NEAR(pre.covariance(6, 6),
              9e-6 * 0.125 / 3.0 + 4e-6 * 13.0 * std::pow(0.5, 5) / 20.0 + 1e-12, 1e-13);
  EXPECT_LE((pre.J_q_bg + 0.5 * Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LE((pre.J_v_ba + 0.5 * Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LE((pre.J_p_ba + 0.125 * Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LE((pre.J_v_bg - 0.125 * Skew(Vector3d(1, 2, -3))).norm(), 1e-12);
  EXPECT_LE((pre.J_p_bg - 0.125 / 6.0 * Skew(Vector3d(1, 2, -3))).norm(), 1e-12);
}

// The rotation exceeds 2 pi and the force rotates with the body: small-angle formulas would fail.
// One sample rotates by 0.7 rad.
TEST(Preintegrate, FastConstantRotation) {
  const Vector3d w(5.0, -3.0, 4.0), f(1.0, 2.0, 9.0);
  ImuData imu;
  imu.nominal_dt_s = 0.1;
  for (int i = 1; i <= 20; ++i) imu.samples.push_back({0.1 * i, 0.1, w, f});
  const Preintegrated pre = Preintegrate(imu, 0.0, 2.0, {}, kNoise);
  const double angle = w.norm() * 2.0;
  const Vector3d axis = w.normalized();
  const Vector3d along = axis * axis.dot(f), across = f - along, side = axis.cross(f);
  const Vector3d v =
      2.0 * (along + std::sin(angle) / angle * across + (1.0 - std::cos(angle)) / angle * side);
  const Vector3d p = 4.0 * (0.5 * along + (1.0 - std::cos(angle)) / (angle * angle) * across +
                            (angle - std::sin(angle)) / (angle * angle) * side);
  EXPECT_LE(pre.delta_q.angularDistance(Exp(Vector3d(2.0 * w))), 1e-12);
  EXPECT_LE((pre.delta_v - v).norm(), 1e-12);
  EXPECT_LE((pre.delta_p - p).norm(), 1e-12);
}

/// Scale factor of the gyro: measured = (1 + s) true, per axis.
class GyroScale final : public ImuEffect {
 public:
  int components() const override { return 3; }
  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               ImuReading* reading) const override {
    const Vector3d inverse = (1.0 + value.array()).inverse();
    reading->w_b = inverse.cwiseProduct(reading->w_b);
    reading->J_w = inverse.asDiagonal() * reading->J_w;
    reading->J_w.middleCols<3>(column).diagonal() = -inverse.cwiseProduct(reading->w_b);
  }
};

/// The gyro also measures the specific force times the value, per axis. The accelerometers have a
/// bias in a window.
class Mixed final : public ImuEffect {
 public:
  int components() const override { return 6; }
  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               ImuReading* reading) const override {
    const bool inside = reading->t_s > 0.6 && reading->t_s < 0.9;
    if (inside) {
      reading->f_b -= value.tail<3>();
      reading->J_f.middleCols<3>(column + 3).diagonal().setConstant(-1.0);
    }
    reading->w_b -= value.head<3>().cwiseProduct(reading->f_b);
    reading->J_w -= value.head<3>().asDiagonal() * reading->J_f;
    reading->J_w.middleCols<3>(column).diagonal() = -reading->f_b;
  }
};

ImuCorrection WithEffects(const Vector3d& gyro_bias, const Vector3d& accel_bias,
                          const Eigen::VectorXd& mixed, const Eigen::VectorXd& scale) {
  static const auto mixed_effect = std::make_shared<Mixed>();
  static const auto scale_effect = std::make_shared<GyroScale>();
  return {gyro_bias, accel_bias, {{mixed_effect, mixed}, {scale_effect, scale}}};
}

constexpr double kBiasTolerance =
    3e-5;  // second order in the change, and the slope within a sample
constexpr double kScaleTolerance = 1e-3;  // the coning of 1e-5 rad/s is not differentiated
// Coning by the vibration that g-sensitivity transfers to the gyro.
constexpr double kForceTolerance = 1e-2;

void ExpectPredicted(const Preintegrated& pre, const Preintegrated& moved,
                     const Eigen::Matrix<double, 9, 1>& change, double relative) {
  const Vector3d turned = Log(Eigen::Quaterniond(pre.delta_q.conjugate() * moved.delta_q));
  const Vector3d rotation = change.head<3>(), velocity = change.segment<3>(3),
                 position = change.tail<3>();
  EXPECT_LE((turned - rotation).norm(), relative * rotation.norm() + 1e-15);
  EXPECT_LE((moved.delta_v - pre.delta_v - velocity).norm(), relative * velocity.norm());
  EXPECT_LE((moved.delta_p - pre.delta_p - position).norm(), relative * position.norm());
}

TEST(Preintegrate, JacobiansPredictIntegrationWithOtherBiases) {
  const ImuData imu = testing::VibratingMotion().Measure(0.0, 2.0, 200.0);
  const double t0_s = 0.3012, t1_s = 1.3049;
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const Vector3d bg = testing::RandomVector(rng, 1e-2), ba = testing::RandomVector(rng, 0.1);
    const Vector3d d_bg = testing::RandomVector(rng, 1e-6), d_ba = testing::RandomVector(rng, 1e-5);
    Eigen::VectorXd mixed(6);
    mixed << Vector3d::Zero(), testing::RandomVector(rng, 0.1);
    const Eigen::VectorXd scale = testing::RandomVector(rng, 1e-2);
    for (const bool with_effects : {false, true}) {
      const auto integrate = [&](const Vector3d& gyro, const Vector3d& accel) {
        const ImuCorrection at =
            with_effects ? WithEffects(gyro, accel, mixed, scale) : ImuCorrection{gyro, accel};
        return Preintegrate(imu, t0_s, t1_s, at, kNoise);
      };
      const Preintegrated pre = integrate(bg, ba);
      Eigen::Matrix<double, 9, 1> by_gyro, by_accel;
      by_gyro << pre.J_q_bg * d_bg, pre.J_v_bg * d_bg, pre.J_p_bg * d_bg;
      by_accel << Vector3d::Zero(), pre.J_v_ba * d_ba, pre.J_p_ba * d_ba;
      ExpectPredicted(pre, integrate(bg + d_bg, ba), by_gyro, kBiasTolerance);
      ExpectPredicted(pre, integrate(bg, ba + d_ba), by_accel, kBiasTolerance);
    }
  }
}

TEST(Preintegrate, JacobiansPredictIntegrationWithOtherEffects) {
  const ImuData imu = testing::VibratingMotion().Measure(0.0, 2.0, 200.0);
  const double t0_s = 0.3012, t1_s = 1.3049;
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const Vector3d bg = testing::RandomVector(rng, 1e-2), ba = testing::RandomVector(rng, 0.1);
    Eigen::VectorXd values(9), step(9);
    values << testing::RandomVector(rng, 1e-3), testing::RandomVector(rng, 0.1),
        testing::RandomVector(rng, 1e-2);
    step << testing::RandomVector(rng, 1e-7), testing::RandomVector(rng, 1e-5),
        testing::RandomVector(rng, 1e-5);
    const auto integrate = [&](const Eigen::VectorXd& x) {
      return Preintegrate(imu, t0_s, t1_s, WithEffects(bg, ba, x.head(6), x.tail(3)), kNoise);
    };
    const Preintegrated pre = integrate(values);
    ASSERT_EQ(pre.J_effects.cols(), 9);
    for (const auto& [first, relative] :
         {std::pair{0, kForceTolerance}, std::pair{3, kScaleTolerance},
          std::pair{6, kScaleTolerance}}) {
      Eigen::VectorXd d = Eigen::VectorXd::Zero(9);
      d.segment<3>(first) = step.segment<3>(first);
      ExpectPredicted(pre, integrate(values + d), pre.J_effects * d, relative);
    }
  }
}

TEST(Preintegrate, JacobiansOfEffectsCompose) {
  const ImuData imu = testing::VibratingMotion().Measure(0.0, 2.0, 200.0);
  Eigen::VectorXd mixed(6);
  mixed << 1e-3, -2e-3, 5e-4, 0.1, 0.2, -0.1;
  const ImuCorrection at =
      WithEffects({1e-3, 0.0, 0.0}, {0.0, 0.1, 0.0}, mixed, Vector3d(1e-2, -5e-3, 2e-3));
  const Preintegrated whole = Preintegrate(imu, 0.4, 1.2, at, kNoise);
  const Preintegrated composed =
      Compose(Preintegrate(imu, 0.4, 0.755, at, kNoise), Preintegrate(imu, 0.755, 1.2, at, kNoise));
  EXPECT_LE((composed.J_effects - whole.J_effects).norm(), 1e-12 * whole.J_effects.norm());
  EXPECT_LE((composed.J_q_bg - whole.J_q_bg).norm(), 1e-12);
}

// The corrections are removed exactly, in the reverse order of the sensor.
TEST(Preintegrate, CorrectionsAreSubtracted) {
  Eigen::VectorXd mixed(6);
  mixed << 1e-3, -2e-3, 5e-4, 0.0, 0.0, 0.0;
  const ImuCorrection at =
      WithEffects({1e-3, -2e-3, 3e-3}, {0.1, -0.2, 0.05}, mixed, Vector3d(1e-3, -2e-3, 5e-4));
  const ImuData clean = testing::PlaneMotion().Measure(0.0, 1.0, 100.0);
  ImuData spoiled = clean;
  for (ImuSample& sample : spoiled.samples) {
    const Vector3d scale = at.effects[1].value;
    sample.w_ib_b_radps += scale.cwiseProduct(sample.w_ib_b_radps) + at.gyro_bias_radps +
                           mixed.head<3>().cwiseProduct(sample.f_b_mps2);
    sample.f_b_mps2 += at.accel_bias_mps2;
  }
  ExpectSame(Preintegrate(spoiled, 0.1, 0.9, at, kNoise), Preintegrate(clean, 0.1, 0.9, {}, kNoise),
             1e-13);
  EXPECT_LE((IdentityIncrement(spoiled, 0.503, at).w_end_b_radps -
             IdentityIncrement(clean, 0.503, {}).w_end_b_radps)
                .norm(),
            1e-15);
}

TEST(Preintegrate, RejectsAnEffectOfTheWrongSize) {
  const ImuData imu = testing::PlaneMotion().Measure(0.0, 1.0, 100.0);
  ImuCorrection at = WithEffects(Vector3d::Zero(), Vector3d::Zero(), Eigen::VectorXd::Zero(6),
                                 Eigen::VectorXd::Zero(2));
  EXPECT_THROW(Preintegrate(imu, 0.1, 0.9, at, kNoise), InvalidInput);
  at.effects = {at.effects[0], {at.effects[1].effect, Eigen::VectorXd::Constant(3, std::nan(""))}};
  EXPECT_THROW(Preintegrate(imu, 0.1, 0.9, at, kNoise), InvalidInput);
}

TEST(Preintegrate, PositionFloorEntersOnce) {
  const ImuData imu = testing::PlaneMotion().Measure(0.0, 1.0, 100.0);
  const Preintegrated without = Preintegrate(imu, 0.0, 1.0, {}, {kArw, kVrw, 0.0});
  const Preintegrated with = Preintegrate(imu, 0.0, 1.0, {}, {kArw, kVrw, 1e-3});
  Eigen::Matrix<double, 9, 1> added = Eigen::Matrix<double, 9, 1>::Zero();
  added.tail<3>().setConstant(1e-6);
  EXPECT_LE((with.covariance.diagonal() - without.covariance.diagonal() - added).norm(), 1e-20);
}

void ExpectSameMotion(const InertialIncrements& a, const InertialIncrements& b) {
  EXPECT_EQ(a.t_begin_s, b.t_begin_s);
  EXPECT_EQ(a.t_end_s, b.t_end_s);
  EXPECT_EQ(a.delta_q.coeffs(), b.delta_q.coeffs());
  EXPECT_EQ(a.delta_v, b.delta_v);
  EXPECT_EQ(a.delta_p, b.delta_p);
  EXPECT_EQ(a.w_end_b_radps, b.w_end_b_radps);
  EXPECT_EQ(a.f_end_b_mps2, b.f_end_b_mps2);
}

void ExpectSameBits(const Preintegrated& a, const Preintegrated& b) {
  ExpectSameMotion(a, b);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.J_q_bg, b.J_q_bg);
  EXPECT_EQ(a.J_v_ba, b.J_v_ba);
  EXPECT_EQ(a.J_p_bg, b.J_p_bg);
  EXPECT_EQ(a.J_effects, b.J_effects);
}

TEST(IncrementalPreintegrator, AgreeWithPreintegrate) {
  ImuData imu = testing::VibratingMotion().Measure(0.0, 2.0, 200.0);
  imu.bridges.push_back({imu.samples[160].t_s - 0.01, imu.samples[160], 1e-4, 1e-3});
  const PreintegrationNoise noise{kArw, kVrw, 1e-6, {{0.7, 0.9, 1e-3, 1e-2}}};
  const Eigen::VectorXd mixed = 1e-3 * Eigen::VectorXd::Ones(6);
  const ImuCorrection plain{{1e-3, 0.0, 0.0}, {0.0, 0.1, 0.0}, {}};
  const ImuCorrection with_effects =
      WithEffects({1e-3, 0.0, 0.0}, {0.0, 0.1, 0.0}, mixed, Vector3d(1e-2, -5e-3, 2e-3));
  for (const ImuCorrection& at : {plain, with_effects}) {
    IncrementalPreintegrator growing(imu, 0.4021, at, noise);
    for (const double end_s : {0.4022, 0.405, 0.4061, 0.4061, 0.73, 0.8049, 0.805, 0.8051, 1.999}) {
      SCOPED_TRACE(end_s);
      ExpectSameBits(growing.To(end_s), Preintegrate(imu, 0.4021, end_s, at, noise));
    }
    EXPECT_THROW(growing.To(1.9), InvalidInput);
    EXPECT_THROW(growing.To(2.1), InvalidInput);
  }
}

TEST(IncrementalMotionIntegrator, AgreesWithPreintegrate) {
  ImuData imu = testing::VibratingMotion().Measure(0.0, 2.0, 200.0);
  const ImuCorrection plain{{1e-3, 0.0, 0.0}, {0.0, 0.1, 0.0}, {}};
  const ImuCorrection with_effects =
      WithEffects({1e-3, 0.0, 0.0}, {0.0, 0.1, 0.0}, 1e-3 * Eigen::VectorXd::Ones(6),
                  Vector3d(1e-2, -5e-3, 2e-3));
  for (const ImuCorrection& at : {plain, with_effects}) {
    IncrementalMotionIntegrator growing(imu, 0.4021, at);
    for (const double end_s : {0.4022, 0.405, 0.4061, 0.4061, 0.73, 0.8049, 0.805, 0.8051, 1.999}) {
      SCOPED_TRACE(end_s);
      const Preintegrated whole = Preintegrate(imu, 0.4021, end_s, at, {kArw, kVrw, 1e-6});
      ExpectSameMotion(growing.To(end_s), whole);
      ExpectSameMotion(IntegrateMotion(imu, 0.4021, end_s, at), whole);
    }
    EXPECT_THROW(growing.To(1.9), InvalidInput);
    EXPECT_THROW(growing.To(2.1), InvalidInput);
    EXPECT_THROW(IntegrateMotion(imu, 0.5, 0.5, at), InvalidInput);
  }
  imu.samples.erase(imu.samples.begin() + 50, imu.samples.begin() + 52);
  EXPECT_THROW(IntegrateMotion(imu, 0.1, 0.5, plain), InvalidInput);
}

TEST(IdentityIncrement, IsTheLimitOfAShortInterval) {
  const ImuData imu = testing::PlaneMotion().Measure(0.0, 1.0, 100.0);
  const ImuCorrection bias{{1e-3, 0, 0}, {0, 0.1, 0}};
  for (const double t_s : {0.25, 0.253, imu.samples.back().t_s}) {
    const Preintegrated at = IdentityIncrement(imu, t_s, bias);
    const Preintegrated before = Preintegrate(imu, t_s - 1e-3, t_s, bias, kNoise);
    EXPECT_EQ(at.dt_s(), 0.0);
    EXPECT_TRUE(at.covariance.isZero(0.0));
    EXPECT_EQ(at.delta_q.w(), 1.0);
    EXPECT_EQ(at.w_end_b_radps, before.w_end_b_radps);
    EXPECT_EQ(at.f_end_b_mps2, before.f_end_b_mps2);
  }
  EXPECT_NO_THROW(IdentityIncrement(imu, 0.0, bias));
  EXPECT_THROW(IdentityIncrement(imu, -0.01, bias), InvalidInput);
  EXPECT_THROW(IdentityIncrement(imu, 1.01, bias), InvalidInput);
}

// The rate at the end of a sample extrapolates the linear model of the sample.
TEST(Preintegrate, EndRatesAreThoseOfTheMotion) {
  const EarthMotion motion = testing::PlaneMotion();
  const ImuData imu = motion.Measure(0.0, 1.0, 200.0);
  const Preintegrated pre = Preintegrate(imu, 0.2, 0.6037, {}, kNoise);
  EXPECT_LE((pre.w_end_b_radps - motion.AngularRate(0.6037)).norm(), 1e-5);  // w'' h^2 / 12
  EXPECT_LE((pre.f_end_b_mps2 - motion.SpecificForce(0.6037)).norm(), 1e-4);
}

TEST(Preintegrate, RejectsABiasThatIsNotFinite) {
  const ImuData imu = testing::PlaneMotion().Measure(0.0, 1.0, 100.0);
  const Vector3d zero = Vector3d::Zero();
  const Vector3d inf(0, std::numeric_limits<double>::infinity(), 0);
  const auto message = [&](const ImuCorrection& bias) -> std::string {
    try {
      Preintegrate(imu, 0.5, 0.6, bias, kNoise);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message({inf, zero}).find("bias of the gyros at t = 0.500000 s"), std::string::npos);
  EXPECT_NE(message({zero, inf}).find("bias of the accelerometers at t = 0.5"), std::string::npos);
}

TEST(Preintegrate, RejectsIntervalsWithoutData) {
  ImuData imu = testing::PlaneMotion().Measure(0.0, 1.0, 100.0);
  EXPECT_THROW(Preintegrate(imu, 0.5, 0.5, {}, kNoise), InvalidInput);
  EXPECT_THROW(Preintegrate(imu, 0.5, 0.4, {}, kNoise), InvalidInput);
  EXPECT_THROW(Preintegrate(imu, -0.001, 0.4, {}, kNoise), InvalidInput);
  EXPECT_THROW(Preintegrate(imu, 0.5, 1.001, {}, kNoise), InvalidInput);
  EXPECT_THROW(Preintegrate({}, 0.5, 0.6, {}, kNoise), InvalidInput);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Preintegrate(imu, nan, 0.6, {}, kNoise), InvalidInput);
  EXPECT_THROW(Preintegrate(imu, 0.5, 0.6, {{nan, 0, 0}, {0, 0, 0}}, kNoise), InvalidInput);
  EXPECT_THROW(Preintegrate(imu, 0.5, 0.6, {}, {-1.0, kVrw, 1e-6}), InvalidInput);
  EXPECT_NO_THROW(Preintegrate(imu, 0.0, 1.0 + 1e-9, {}, kNoise));

  imu.samples.erase(imu.samples.begin() + 50, imu.samples.begin() + 52);
  EXPECT_THROW(Preintegrate(imu, 0.4, 0.6, {}, kNoise), InvalidInput);
  EXPECT_THROW(IdentityIncrement(imu, 0.51, {}), InvalidInput);
  EXPECT_NO_THROW(Preintegrate(imu, 0.4, 0.5, {}, kNoise));
  EXPECT_NO_THROW(Preintegrate(imu, 0.52, 0.6, {}, kNoise));
}

}  // namespace dn::imu_test
