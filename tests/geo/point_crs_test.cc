#include <dn/geo/point_crs.h>
#include <gtest/gtest.h>

#include <cmath>

#include "testing/expect_invalid.h"

namespace dn::geo_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::ExpectInvalid;

const LocalFrame kSierra({37.8 * kRadPerDeg, -119.0 * kRadPerDeg, 2600.0});

// One point of a public point cloud, projected by PROJ to both systems and rounded to 1 cm.
const Vector3d kUtm(320000.34, 4181319.35, 2687.59);
const Vector3d kEcef(-2452030.8656976963, -4415677.988863611, 3886195.4099422703);
constexpr double kRoundingM = 0.01;

TEST(PointCrs, UtmAndEcefOfOnePointAgree) {
  const Vector3d from_utm_m = PointCrs("utm:11n", kSierra).ToMap(kUtm);
  const Vector3d from_ecef_m = PointCrs("ecef", kSierra).ToMap(kEcef);
  EXPECT_LT((from_utm_m - from_ecef_m).norm(), 2.0 * kRoundingM);
}

TEST(PointCrs, ThereAndBack) {
  const Vector3d p_m(5000.0, -7000.0, -300.0);
  for (const char* name : {"map", "utm:11n", "utm:10n", "ecef"}) {
    const PointCrs crs(name, kSierra);
    EXPECT_LT((crs.ToMap(crs.FromMap(p_m)) - p_m).norm(), 1e-7) << name;
  }
}

TEST(PointCrs, SouthernZonesCountFromTheirFalseOrigin) {
  const LocalFrame cape({-34.0 * kRadPerDeg, 18.5 * kRadPerDeg, 100.0});
  const Vector3d p_c = PointCrs("utm:34s", cape).FromMap(Vector3d::Zero());
  EXPECT_NEAR(p_c.z(), 100.0, 1e-7);
  EXPECT_GT(p_c.y(), 6.2e6);  // 34 deg south of the equator: 10000 - 3764 km
  EXPECT_LT(p_c.y(), 6.3e6);
  EXPECT_LT(PointCrs("utm:34s", cape).ToMap(p_c).norm(), 1e-7);
}

TEST(PointCrs, JacobianIsTheDerivative) {
  const Vector3d p_m(5000.0, -7000.0, -300.0);
  for (const char* name : {"map", "utm:11n", "ecef"}) {
    const PointCrs crs(name, kSierra);
    Matrix3d numeric;
    constexpr double kStepM = 10.0;
    for (int i = 0; i < 3; ++i) {
      const Vector3d step_m = kStepM * Vector3d::Unit(i);
      numeric.col(i) = (crs.FromMap(p_m + step_m) - crs.FromMap(p_m - step_m)) / (2.0 * kStepM);
    }
    // The grid scale changes with height by 1e-4 over 700 m; the Jacobian is that at the ellipsoid.
    EXPECT_LT((crs.J_c_m(p_m) - numeric).cwiseAbs().maxCoeff(), 1e-3) << name;
  }
}

TEST(PointCrs, CoordinatesOfAnotherSystemAreRefused) {
  const auto to_map = [](const char* name, const Vector3d& p_c) {
    return [=] { PointCrs(name, kSierra).ToMap(p_c); };
  };
  ExpectInvalid(to_map("map", kUtm), "not a valid point in the mapping frame", 0);
  ExpectInvalid(to_map("map", {std::nan(""), 0, 0}), "not a valid point in the mapping frame", 0);
  ExpectInvalid(to_map("utm:11n", kEcef), "not a valid point in UTM", 0);
  ExpectInvalid(to_map("utm:11n", {-119.0, 37.8, 2600.0}), "not a valid point in UTM", 0);
  ExpectInvalid(to_map("ecef", kUtm), "not a valid point in ECEF", 0);
}

TEST(PointCrs, Names) {
  for (const char* name : {"map", "ecef", "none", "utm:1n", "utm:60s"}) {
    EXPECT_TRUE(IsPointCrsName(name)) << name;
  }
  for (const char* name : {"", "utm:0n", "utm:61n", "utm:11", "UTM:11n", "utm:11N", "4326"}) {
    EXPECT_FALSE(IsPointCrsName(name)) << name;
  }
  EXPECT_THROW(PointCrs("none", kSierra), InvalidConfig);
}

}  // namespace dn::geo_test
