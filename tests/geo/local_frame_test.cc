#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "testing/random.h"

namespace dn::geo_test {

// Defining and derived constants of WGS84 (NGA.STND.0036).
constexpr double kSemiMajorAxisM = 6378137.0;
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double kEccentricitySquared = kFlattening * (2.0 - kFlattening);
constexpr double kEquatorGravityMps2 = 9.7803253359;
constexpr double kSomigliana = 0.00193185265241;

// Rounding of coordinates as large as the Earth's radius.
constexpr double kFrameToleranceM = 5e-9;
// The published constants have 11 significant digits.
constexpr double kGravityToleranceMps2 = 1e-9;

const Geodetic kLausanne{46.57 * kRadPerDeg, 6.52 * kRadPerDeg, 500.0};

Eigen::Vector3d EcefByClosedFormula(const Geodetic& g) {
  const double s = std::sin(g.lat_rad), c = std::cos(g.lat_rad);
  const double N_m = kSemiMajorAxisM / std::sqrt(1.0 - kEccentricitySquared * s * s);
  return {(N_m + g.h_m) * c * std::cos(g.lon_rad), (N_m + g.h_m) * c * std::sin(g.lon_rad),
          (N_m * (1.0 - kEccentricitySquared) + g.h_m) * s};
}

double SomiglianaGravity(double lat_rad) {
  const double s2 = std::sin(lat_rad) * std::sin(lat_rad);
  return kEquatorGravityMps2 * (1.0 + kSomigliana * s2) /
         std::sqrt(1.0 - kEccentricitySquared * s2);
}

Geodetic RandomPoint(std::mt19937& rng) {
  const Eigen::Vector3d u = testing::RandomVector(rng, 1.0);
  return {1.5 * u.x(), 3.1 * u.y(), 5000.0 * u.z()};
}

TEST(LocalFrame, EcefAgreesWithTheClosedFormula) {
  std::mt19937 rng(1);
  for (int i = 0; i < 50; ++i) {
    const Geodetic g = RandomPoint(rng);
    EXPECT_LE((ToEcef(g) - EcefByClosedFormula(g)).norm(), kFrameToleranceM);
    const Geodetic back = GeodeticFromEcef(ToEcef(g));
    EXPECT_LE((EcefByClosedFormula(back) - EcefByClosedFormula(g)).norm(), kFrameToleranceM);
  }
}

TEST(LocalFrame, AxesAreEastNorthUpOfTheOrigin) {
  const LocalFrame frame(kLausanne);
  const double s = std::sin(kLausanne.lat_rad), c = std::cos(kLausanne.lat_rad);
  const double sl = std::sin(kLausanne.lon_rad), cl = std::cos(kLausanne.lon_rad);
  Eigen::Matrix3d R_me;
  R_me << -sl, cl, 0, -s * cl, -s * sl, c, c * cl, c * sl, s;
  EXPECT_LE((frame.R_me() - R_me).norm(), 1e-15);
  EXPECT_LE(frame.ToMap(kLausanne).norm(), kFrameToleranceM);
  EXPECT_LE((frame.r0_m() - R_me * EcefByClosedFormula(kLausanne)).norm(), kFrameToleranceM);
}

TEST(LocalFrame, MapIsEcefTurnedAndMoved) {
  const LocalFrame frame(kLausanne);
  std::mt19937 rng(2);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p_m = testing::RandomVector(rng, 5e4);
    const Geodetic g = frame.ToGeodetic(p_m);
    EXPECT_LE((frame.ToMap(g) - p_m).norm(), kFrameToleranceM);
    const Eigen::Vector3d expected =
        frame.R_me() * (EcefByClosedFormula(g) - EcefByClosedFormula(kLausanne));
    EXPECT_LE((p_m - expected).norm(), kFrameToleranceM);
  }
}

TEST(LocalFrame, EarthRatePointsNorthAndUpByTheLatitude) {
  const LocalFrame frame(kLausanne);
  const Eigen::Vector3d expected(0.0, 7.292115e-5 * std::cos(kLausanne.lat_rad),
                                 7.292115e-5 * std::sin(kLausanne.lat_rad));
  EXPECT_LE((frame.w_ie_m() - expected).norm(), 1e-19);
}

TEST(LocalFrame, GravityOnTheEllipsoidIsSomiglianas) {
  for (const double lat_deg : {-90.0, -45.0, 0.0, 30.0, 46.57, 90.0}) {
    SCOPED_TRACE(lat_deg);
    const LocalFrame frame({lat_deg * kRadPerDeg, 0.3, 0.0});
    const Eigen::Vector3d expected(0.0, 0.0, -SomiglianaGravity(lat_deg * kRadPerDeg));
    EXPECT_LE((frame.Gravity(Eigen::Vector3d::Zero()) - expected).norm(), kGravityToleranceMps2);
  }
}

// Free-air reduction to second order in height (Heiskanen & Moritz, eq. 2-215 with WGS84's m).
TEST(LocalFrame, GravityDecreasesWithHeight) {
  constexpr double kM = 0.00344978650684;
  constexpr double kTruncationMps2 = 1e-6;
  const LocalFrame frame({kLausanne.lat_rad, kLausanne.lon_rad, 0.0});
  const double h_m = 2000.0, s2 = std::pow(std::sin(kLausanne.lat_rad), 2);
  const double ratio =
      1.0 - 2.0 / kSemiMajorAxisM * (1.0 + kFlattening + kM - 2.0 * kFlattening * s2) * h_m +
      3.0 * std::pow(h_m / kSemiMajorAxisM, 2);
  EXPECT_NEAR(-frame.Gravity({0.0, 0.0, h_m}).z(), SomiglianaGravity(kLausanne.lat_rad) * ratio,
              kTruncationMps2);
}

TEST(LocalFrame, GravityFollowsThePlumbLineOfThePoint) {
  const LocalFrame frame({kLausanne.lat_rad, kLausanne.lon_rad, 0.0});
  const Geodetic g{kLausanne.lat_rad + 0.002, kLausanne.lon_rad - 0.003, 0.0};
  const Eigen::Vector3d p_m = frame.ToMap(g);
  const Eigen::Vector3d down_m = frame.R_mn(p_m).col(2);
  EXPECT_LE((frame.Gravity(p_m) - SomiglianaGravity(g.lat_rad) * down_m).norm(),
            kGravityToleranceMps2);
}

TEST(LocalFrame, GravityIsAttractionAndCentrifugalForce) {
  const LocalFrame frame(kLausanne);
  std::mt19937 rng(3);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d p_m = testing::RandomVector(rng, 3e4);
    const Eigen::Vector3d rho_m = frame.r0_m() + p_m;
    const Eigen::Vector3d& w = frame.w_ie_m();
    const Eigen::Vector3d centrifugal = -w.cross(w.cross(rho_m));
    EXPECT_LE((frame.Gravity(p_m) - frame.Gravitation(p_m) - centrifugal).norm(), 1e-14);
  }
}

// A point 20 km to the east: down is tilted by distance / N, and north rotated by that times
// tan(latitude).
TEST(LocalFrame, NorthEastDownIsThatOfThePoint) {
  const Geodetic origin{kLausanne.lat_rad, kLausanne.lon_rad, 0.0};
  const LocalFrame frame(origin);
  const Eigen::Vector3d p_m(20000.0, 0.0, 0.0);
  const double N_m = kSemiMajorAxisM /
                     std::sqrt(1.0 - kEccentricitySquared * std::pow(std::sin(origin.lat_rad), 2));
  const double tilt_rad = 20000.0 / N_m;
  constexpr double kSecondOrderRad = 2e-5;
  const Eigen::Matrix3d R_mn = frame.R_mn(p_m);
  EXPECT_NEAR(tilt_rad * kDegPerRad, 0.18, 0.001);
  EXPECT_LE((R_mn.col(2) - Eigen::Vector3d(-tilt_rad, 0.0, -1.0)).norm(), kSecondOrderRad);
  EXPECT_LE((R_mn.col(0) - Eigen::Vector3d(-tilt_rad * std::tan(origin.lat_rad), 1.0, 0.0)).norm(),
            kSecondOrderRad);
  EXPECT_LE((R_mn - frame.R_me() * R_en(frame.ToGeodetic(p_m))).norm(), 1e-15);
}

TEST(LocalFrame, EnuAndNedOfAPointNameTheSameAxes) {
  const LocalFrame frame(kLausanne);
  const Eigen::Vector3d p_m(-3000.0, 8000.0, 200.0);
  const Eigen::Matrix3d ned = frame.R_mn(p_m), enu = frame.R_m_enu(p_m);
  EXPECT_EQ(enu.col(0), ned.col(1));
  EXPECT_EQ(enu.col(1), ned.col(0));
  EXPECT_EQ(enu.col(2), -ned.col(2));
  EXPECT_NEAR(ned.determinant(), 1.0, 1e-14);
}

TEST(LocalFrame, CopiesOutliveTheOriginal) {
  auto original = std::make_unique<LocalFrame>(kLausanne);
  const LocalFrame copy = *original;
  original.reset();
  EXPECT_EQ(copy.origin().h_m, 500.0);
}

TEST(LocalFrame, RejectsImpossibleOrigins) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(LocalFrame({1.6, 0.0, 0.0}), InvalidInput);
  EXPECT_THROW(LocalFrame({nan, 0.0, 0.0}), InvalidInput);
  EXPECT_THROW(LocalFrame({0.0, nan, 0.0}), InvalidInput);
  EXPECT_THROW(LocalFrame({0.0, 6.5 * 57.3, 0.0}), InvalidInput);
  EXPECT_THROW(LocalFrame({0.0, 0.0, std::numeric_limits<double>::infinity()}), InvalidInput);
  EXPECT_NO_THROW(LocalFrame({90.0 * kRadPerDeg, 360.0 * kRadPerDeg, 0.0}));
}

}  // namespace dn::geo_test
