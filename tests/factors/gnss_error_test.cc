#include <dn/error.h>
#include <dn/factors/gnss_error.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "testing/factor_consistency.h"

namespace dn::factors_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::RandomRotation;
using testing::RandomVector;
using testing::State;

/// r = W (p + R a + R_m_enu (sigma_1 c_1 + sigma_2 c_2) - z) by automatic differentiation.
struct AutoPosition : DynamicAutoFactor<AutoPosition> {
  AutoPosition(const Vector3d& z, const GnssProcess& first, const GnssProcess& second,
               const Matrix3d& R, const Noise<3>& noise)
      : DynamicAutoFactor(3, {Rotation::kKind, Vec<3>::kKind, Vec<3>::kKind, Vec<3>::kKind,
                              Vec<3>::kKind, Vec<3>::kKind}),
        z_m(z),
        sigma_1(first.sigma_enu_m),
        sigma_2(second.sigma_enu_m),
        R_m_enu(R),
        W(noise.sqrt_information()) {}

  template <class T>
  bool Residual(const T* const* x, T* r_data) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Eigen::Quaternion<T>> q(x[0]);
    const Eigen::Map<const Vec3> p(x[1]), a(x[2]), c_1(x[4]), c_2(x[5]);
    const Vec3 error = sigma_1.cast<T>().cwiseProduct(c_1) + sigma_2.cast<T>().cwiseProduct(c_2);
    Eigen::Map<Vec3> r(r_data);
    r = W.cast<T>() * (p + q * a + R_m_enu.cast<T>() * error - z_m.cast<T>());
    return true;
  }

  Vector3d z_m, sigma_1, sigma_2;
  Matrix3d R_m_enu, W;
};

GnssAntenna Position(const Vector3d& z_m, const std::vector<GnssProcess>& processes,
                     const Matrix3d& R_m_enu, const Noise<3>& noise) {
  GnssEffects errors;
  for (const GnssProcess& process : processes) {
    errors.push_back(std::make_shared<CorrelatedGnssError>(process, R_m_enu));
  }
  return GnssAntenna(GnssAntenna::Quantity::kPosition, z_m, {}, errors, noise);
}

TEST(CorrelatedGnssError, JacobiansAgreeAtRandomStates) {
  Matrix3d covariance;
  covariance << 4e-4, 1e-4, 0, 1e-4, 9e-4, -2e-4, 0, -2e-4, 25e-4;
  const Noise<3> noise = Noise<3>::Covariance(covariance);
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const Matrix3d R_m_enu = RandomRotation(rng).toRotationMatrix();
    const GnssProcess first{RandomVector(rng, 0.1).cwiseAbs(), 120.0};
    const GnssProcess second{{0.0, 0.3, 0.0}, 10.0};
    const Vector3d z_m = RandomVector(rng, 1e3);
    const GnssAntenna factor = Position(z_m, {first, second}, R_m_enu, noise);
    const AutoPosition twin(z_m, first, second, R_m_enu, noise);
    testing::ExpectFactorConsistent(
        factor,
        {State(RandomRotation(rng)), RandomVector(rng, 1e3), RandomVector(rng, 2.0),
         RandomVector(rng, 60.0), RandomVector(rng, 2.0), RandomVector(rng, 2.0)},
        testing::DynamicAutodiff(twin));
  }
}

// Hand calculation with c at half a sigma east and two sigmas up. The measured antenna is then 5 mm
// east of the true one and 4 cm above it. The map is rotated by 90 degrees about up.
TEST(CorrelatedGnssError, IsOfTheLocalAxesOfThePoint) {
  Matrix3d R_m_enu;
  R_m_enu << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // east at the point is north of the map
  const GnssAntenna factor = Position({10.0, 20.005, 30.04}, {{{0.01, 0.01, 0.02}, 120.0}}, R_m_enu,
                                      Noise<3>::Sigma(0.001));
  const std::vector<Eigen::VectorXd> x{State(Eigen::Quaterniond::Identity()),
                                       Vector3d(10.0, 20.0, 30.0), Vector3d::Zero(),
                                       Vector3d::Zero(), Vector3d(0.5, 0.0, 2.0)};
  Vector3d r;
  ASSERT_TRUE(factor.Evaluate(testing::internal::Pointers(x).data(), r.data(), nullptr));
  EXPECT_LE(r.norm(), 1e-10);
}

TEST(CorrelatedGnssError, AnAxisWithoutSigmaHasNoError) {
  const GnssAntenna factor = Position(Vector3d::Zero(), {{{0.01, 0.0, 0.02}, 120.0}},
                                      Matrix3d::Identity(), Noise<3>::Sigma(0.01));
  const std::vector<Eigen::VectorXd> x{State(Eigen::Quaterniond::Identity()), Vector3d::Zero(),
                                       Vector3d::Zero(), Vector3d::Zero(), Vector3d(1.0, 1e6, 1.0)};
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  ASSERT_TRUE(EvaluateInTangent(factor, testing::internal::Pointers(x), &r, &J));
  EXPECT_EQ(r[1], 0.0);
  EXPECT_TRUE(J[4].col(1).isZero(0.0));
}

TEST(CorrelatedGnssError, RejectsBadInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(CorrelatedGnssError({{-0.01, 0.0, 0.0}, 1.0}, Matrix3d::Identity()), InvalidInput);
  EXPECT_THROW(CorrelatedGnssError({{nan, 0.0, 0.0}, 1.0}, Matrix3d::Identity()), InvalidInput);
}

}  // namespace dn::factors_test
