#include <dn/error.h>
#include <dn/factors/gnss_velocity.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "testing/factor_consistency.h"

namespace dn::factors_test {

using testing::RandomRotation;
using testing::RandomVector;
using testing::State;

const Eigen::Vector3d kEarthRate(0.0, 5.0e-5, 5.3e-5);

Eigen::Vector3d Residual(const GnssVelocity& f, const Eigen::Quaterniond& q_mb,
                         const Eigen::Vector3d& v_m, const Eigen::Vector3d& a_b) {
  Eigen::Vector3d r;
  EXPECT_TRUE(f.Residual(q_mb.coeffs().data(), v_m.data(), a_b.data(), r.data()));
  return r;
}

// Hand calculation: at a rate of 0.5 rad/s about body z, an antenna 2 m ahead moves at 1 m/s along
// body y. A yaw of +90 deg rotates body y to map -x.
TEST(GnssVelocity, ResidualOfATurn) {
  const GnssVelocity f({9.0, 20.0, 30.0}, {0.0, 0.0, 0.5}, Eigen::Vector3d::Zero(),
                       Noise<3>::Sigma(0.25));
  const Eigen::Quaterniond q_mb(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d r = Residual(f, q_mb, {10.0, 21.0, 30.0}, {2.0, 0.0, 0.0});
  EXPECT_LE((r - Eigen::Vector3d(0.0, 4.0, 0.0)).norm(), 1e-14);  // (21 - 20) / 0.25
}

// A body at rest on the Earth measures the Earth rate, but its antenna does not move.
TEST(GnssVelocity, VanishesAtRestOnTheRotatingEarth) {
  std::mt19937 rng(1);
  const Eigen::Quaterniond q_mb = RandomRotation(rng);
  const GnssVelocity f(Eigen::Vector3d::Zero(), q_mb.conjugate() * kEarthRate, kEarthRate,
                       Noise<3>::Sigma(1e-3));
  EXPECT_LE(Residual(f, q_mb, Eigen::Vector3d::Zero(), {100.0, 200.0, 300.0}).norm(), 1e-13);
}

// The antenna velocity is the derivative of its position p(t) + R(t) a along a curved path.
TEST(GnssVelocity, IsTheDerivativeOfTheAntennaPosition) {
  std::mt19937 rng(2);
  const Eigen::Quaterniond q0 = RandomRotation(rng);
  const Eigen::Vector3d v_m = RandomVector(rng, 50.0), a_b = RandomVector(rng, 3.0);
  const Eigen::Vector3d w_eb_b = RandomVector(rng, 0.5);
  const auto antenna = [&](double t_s) -> Eigen::Vector3d {
    return v_m * t_s + q0 * (Exp(Eigen::Vector3d(w_eb_b * t_s)) * a_b);
  };
  constexpr double kStepS = 1e-4, kTruncationMps = 1e-7;
  const Eigen::Vector3d z_m = (antenna(kStepS) - antenna(-kStepS)) / (2.0 * kStepS);
  const GnssVelocity f(z_m, w_eb_b + q0.conjugate() * kEarthRate, kEarthRate, Noise<3>::Sigma(1.0));
  EXPECT_LE(Residual(f, q0, v_m, a_b).norm(), kTruncationMps);
}

TEST(GnssVelocity, JacobiansAgreeAtRandomStates) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    // The Earth rate is as large as the body rate, so that an error in its terms shows.
    const GnssVelocity f(RandomVector(rng, 60.0), RandomVector(rng, 1.0), RandomVector(rng, 1.0),
                         Noise<3>::Sigma({0.02, 0.03, 0.05}));
    testing::ExpectFactorConsistent(
        f,
        {State(RandomRotation(rng)), State(RandomVector(rng, 60.0)), State(RandomVector(rng, 2.0))},
        testing::Autodiff(f));
  }
}

TEST(GnssVelocity, JacobiansAgreeAtSpecialStates) {
  const Eigen::VectorXd v_m = Eigen::Vector3d(4.0, 5.0, 6.0);
  const Eigen::Quaterniond half_turn(0.0, 0.6, 0.0, 0.8);
  for (const Eigen::Vector3d& w_ib_b : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.1, 0.2, 0.3)}) {
    const GnssVelocity f({1, 2, 3}, w_ib_b, kEarthRate, Noise<3>::Sigma(0.02));
    for (const Eigen::Quaterniond& q_mb : {Eigen::Quaterniond::Identity(), half_turn}) {
      for (const Eigen::Vector3d& a_b : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, -1)}) {
        testing::ExpectFactorConsistent(f, {State(q_mb), v_m, State(a_b)}, testing::Autodiff(f));
      }
    }
  }
}

TEST(GnssVelocity, RejectsBadInput) {
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const Eigen::Vector3d nan(0.0, std::numeric_limits<double>::quiet_NaN(), 0.0);
  const Noise<3> noise = Noise<3>::Sigma(0.1);
  EXPECT_THROW(GnssVelocity(nan, zero, zero, noise), InvalidInput);
  EXPECT_THROW(GnssVelocity(zero, nan, zero, noise), InvalidInput);
  EXPECT_THROW(GnssVelocity(zero, zero, nan, noise), InvalidInput);
}

}  // namespace dn::factors_test
