#include <ceres/jet.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <cmath>

#include "testing/random.h"

namespace dn::core_test {

constexpr double kRotationTolerance = 1e-14;  ///< rounding of a few products
// Central differences with step 1e-5: truncation 1e-10 near pi, rounding 1e-11.
constexpr double kRotationStep = 1e-5;
constexpr double kRotationDifferenceTolerance = 1e-9;

/// Angles around every switch between formulas, the identity and pi.
const double kAngles[] = {0.0,     1e-300,  1e-20,   1e-9,       0.99e-8, 1.01e-8,
                          0.99e-4, 1.01e-4, 0.99e-3, 1.01e-3,    0.99e-2, 1.01e-2,
                          0.5,     1.5,     3.0,     M_PI - 1e-8};

template <class Check>
void ForRotationVectors(const Check& check) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    for (const double angle : kAngles) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", angle " + std::to_string(angle));
      std::mt19937 rng(seed);
      check(Eigen::Vector3d(angle * testing::RandomVector(rng, 1.0).normalized()));
    }
  }
}

TEST(Skew, IsTheCrossProduct) {
  const Eigen::Vector3d a(1.0, -2.0, 3.0), b(0.5, 4.0, -1.0);
  EXPECT_EQ(Skew(a) * b, a.cross(b));
  EXPECT_EQ(Skew(a + b) * b, (a + b).cross(b));
  EXPECT_EQ(Skew(Eigen::Map<const Eigen::Vector3d>(a.data())), Skew(a));
}

TEST(Exp, OfAQuarterTurn) {
  const Eigen::Quaterniond q = Exp(Eigen::Vector3d(0.0, 0.0, M_PI / 2));
  EXPECT_LE((q * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), kRotationTolerance);
}

TEST(Exp, AgreesWithAngleAxis) {
  ForRotationVectors([](const Eigen::Vector3d& phi) {
    if (phi.norm() < 1e-200) {
      EXPECT_EQ(Exp(phi).w(), 1.0);
      return;
    }
    const Eigen::Quaterniond expected(Eigen::AngleAxisd(phi.norm(), phi.normalized()));
    EXPECT_LE((Exp(phi).coeffs() - expected.coeffs()).norm(), 1e-15);
  });
}

TEST(Log, UndoesExpToTheLastDigits) {
  ForRotationVectors([](const Eigen::Vector3d& phi) {
    EXPECT_LE((Log(Exp(phi)) - phi).norm(), 4e-15 * phi.norm());
  });
}

TEST(Log, DoesNotDependOnSignOrScale) {
  ForRotationVectors([](const Eigen::Vector3d& phi) {
    const Eigen::Quaterniond q = Exp(phi);
    EXPECT_LE((Log(Eigen::Quaterniond(-q.coeffs())) - phi).norm(), kRotationTolerance);
    EXPECT_LE((Log(Eigen::Quaterniond(1.5 * q.coeffs())) - phi).norm(), kRotationTolerance);
  });
}

TEST(Log, OfAHalfTurn) {
  EXPECT_NEAR(Log(Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0)).norm(), M_PI, kRotationTolerance);
  // Beyond pi, Log returns the shorter rotation.
  const Eigen::Vector3d log = Log(Exp(Eigen::Vector3d(0.0, M_PI + 0.1, 0.0)));
  EXPECT_NEAR(log.y(), -M_PI + 0.1, kRotationTolerance);
}

TEST(ExpAndLog, AreDifferentiableAtZero) {
  using Jet = ceres::Jet<double, 3>;
  Eigen::Matrix<Jet, 3, 1> phi;
  for (int i = 0; i < 3; ++i) phi[i] = Jet(0.0, i);
  const Eigen::Matrix<Jet, 3, 1> log = Log(Exp(phi));
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(log[i].a, 0.0);
    EXPECT_LE((log[i].v - Eigen::Vector3d::Unit(i)).norm(), kRotationTolerance);
  }
}

TEST(RightJacobian, IsTheDerivativeOfExp) {
  ForRotationVectors([](const Eigen::Vector3d& phi) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d d = kRotationStep * Eigen::Vector3d::Unit(k);
      const Eigen::Vector3d difference =
          (Log(Eigen::Quaterniond(Exp(phi).conjugate() * Exp(Eigen::Vector3d(phi + d)))) -
           Log(Eigen::Quaterniond(Exp(phi).conjugate() * Exp(Eigen::Vector3d(phi - d))))) /
          (2.0 * kRotationStep);
      EXPECT_LE((difference - RightJacobian(phi).col(k)).norm(), kRotationDifferenceTolerance);
    }
  });
}

TEST(RightJacobianInverse, IsTheInverse) {
  ForRotationVectors([](const Eigen::Vector3d& phi) {
    const Eigen::Matrix3d product = RightJacobian(phi) * RightJacobianInverse(phi);
    EXPECT_LE((product - Eigen::Matrix3d::Identity()).norm(), kRotationTolerance);
  });
}

// R phi = phi for R = Exp(phi), so phi is an eigenvector of the Jacobian, and Jr(phi) = Exp(-phi)
// Jr(-phi).
TEST(RightJacobian, HasItsSymmetries) {
  ForRotationVectors([](const Eigen::Vector3d& phi) {
    EXPECT_LE((RightJacobian(phi) * phi - phi).norm(), kRotationTolerance);
    const Eigen::Matrix3d R = Exp(Eigen::Vector3d(-phi)).toRotationMatrix();
    EXPECT_LE((RightJacobian(phi) - R * RightJacobian(-phi)).norm(), kRotationTolerance);
  });
}

TEST(RollPitchHeading, HandComputed) {
  // Nose north, right wing down by 90 degrees: body y points down.
  const Eigen::Quaterniond rolled = QuaternionFromRollPitchHeading({M_PI / 2, 0.0, 0.0});
  EXPECT_LE((rolled * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ()).norm(),
            kRotationTolerance);
  // With heading east, body x points east; pitched up by 90 degrees, body x points up.
  const Eigen::Quaterniond east = QuaternionFromRollPitchHeading({0.0, 0.0, M_PI / 2});
  EXPECT_LE((east * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(),
            kRotationTolerance);
  const Eigen::Quaterniond up = QuaternionFromRollPitchHeading({0.0, M_PI / 2, 0.0});
  EXPECT_LE((up * Eigen::Vector3d::UnitX() + Eigen::Vector3d::UnitZ()).norm(), kRotationTolerance);
}

TEST(RollPitchHeading, ReadsBackWhatWasSet) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    Eigen::Vector3d rph = testing::RandomVector(rng, M_PI);
    rph.y() *= 0.49;  // asin loses accuracy near 90 degrees
    EXPECT_LE((RollPitchHeading(QuaternionFromRollPitchHeading(rph)) - rph).norm(), 1e-13);
  }
}

TEST(EulerAngles, RatesInBodyAreTheDerivative) {
  constexpr double kTurn = 1e-6;
  for (const double pitch : {-1.2, 0.0, 0.4, 1.5}) {
    const Eigen::Vector3d rph(0.3, pitch, 2.0);
    const Eigen::Quaterniond q_nb = QuaternionFromRollPitchHeading(rph);
    const Eigen::Matrix3d E = BodyFromEulerRates(q_nb.conjugate() * Eigen::Vector3d::UnitZ());
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = kTurn * Eigen::Vector3d::Unit(i);
      const Eigen::Quaterniond turned = QuaternionFromRollPitchHeading(rph + d);
      const Eigen::Vector3d numeric = Log(Eigen::Quaterniond(q_nb.conjugate() * turned)) / kTurn;
      EXPECT_LE((E.col(i) - numeric).norm(), 2.0 * kTurn) << "pitch " << pitch << ", angle " << i;
    }
  }
}

TEST(EulerAngles, RatesInBodyAreFiniteStraightDown) {
  const Eigen::Matrix3d E = BodyFromEulerRates(-Eigen::Vector3d::UnitX());
  EXPECT_TRUE(E.allFinite());
  EXPECT_EQ(E.col(1), Eigen::Vector3d::UnitY());
}

}  // namespace dn::core_test
