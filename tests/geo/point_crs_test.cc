#include <dn/geo/point_crs.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <thread>
#include <vector>

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
  for (const char* name : {"map", "utm:11n", "utm:10n", "ecef", "utm:11n heights:ft", "epsg:2227",
                           "epsg:3310 heights:us-ft"}) {
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
  for (const char* name : {"map", "utm:11n", "ecef", "epsg:2227", "utm:11n heights:us-ft"}) {
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

TEST(PointCrs, CodesOfTheRegisterEqualTheirShortNames) {
  const Vector3d utm_m = PointCrs("utm:11n", kSierra).ToMap(kUtm);
  for (const char* name : {"epsg:32611", "epsg:26911"}) {
    EXPECT_EQ(ShortCrsName(name), "utm:11n");
    EXPECT_EQ(PointCrs(name, kSierra).name(), "utm:11n");
  }
  // NAD83(2011) has the ellipsoid of GRS80: the same coordinates to a millimetre.
  EXPECT_LT((PointCrs("epsg:6340", kSierra).ToMap(kUtm) - utm_m).norm(), 1e-3);
}

// An example of swisstopo: coordinates of one point in WGS84 and in LV95, rounded to metres.
TEST(PointCrs, ANationalSystemHasItsDatum) {
  const auto angle_rad = [](double deg, double min, double s) {
    return (deg + min / 60.0 + s / 3600.0) * kRadPerDeg;
  };
  const LocalFrame ticino({angle_rad(46, 2, 38.87), angle_rad(8, 43, 49.79), 650.6});
  const Vector3d p_c = PointCrs("epsg:2056", ticino).FromMap(Vector3d::Zero());
  EXPECT_NEAR(p_c.x(), 2700000.0, 2.0);
  EXPECT_NEAR(p_c.y(), 1100000.0, 2.0);
  EXPECT_NEAR(p_c.z(), 600.0, 2.0);
}

TEST(PointCrs, FeetAreConverted) {
  const Vector3d p_m(5000.0, -7000.0, -300.0);
  constexpr double kSurveyFootM = 1200.0 / 3937.0;
  const Vector3d metres = PointCrs("epsg:26943", kSierra).FromMap(p_m);
  const Vector3d feet = PointCrs("epsg:2227 heights:us-ft", kSierra).FromMap(p_m);
  EXPECT_LT((kSurveyFootM * feet - metres).norm(), 1e-3);
}

TEST(PointCrs, UnknownSystemsAndMissingGridsAreNamed) {
  const auto message = [](const std::string& name) -> std::string {
    try {
      PointCrs(name, kSierra).FromMap(Vector3d::Zero());
    } catch (const InvalidConfig& e) {
      return e.what();
    }
    return {};
  };
  EXPECT_NE(message("epsg:999999").find("not a coordinate system that PROJ knows"),
            std::string::npos);
  EXPECT_NE(message("epsg:4326").find("not a projected one"), std::string::npos);
  // A projection of the old British datum is wrong by metres without the grid of the survey.
  EXPECT_NE(message("epsg:27700").find("needs the grid uk_os_OSTN15"), std::string::npos);
  EXPECT_NE(message("epsg:25832+7837").find("needs the grid"), std::string::npos);
}

TEST(PointCrs, ThreadsShareASystem) {
  const PointCrs crs("epsg:2227", kSierra);
  const Vector3d p_m(500.0, -700.0, -30.0);
  std::vector<Vector3d> back(4);
  std::vector<std::thread> threads;
  for (Vector3d& result : back) {
    threads.emplace_back([&] {
      for (int k = 0; k < 1000; ++k) result = crs.ToMap(crs.FromMap(p_m));
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const Vector3d& result : back) EXPECT_LT((result - p_m).norm(), 1e-7);
}

TEST(CrsNames, OfCodesAndText) {
  EXPECT_EQ(NameCrs("EPSG:32632").name, "utm:32n");
  EXPECT_EQ(NameCrs("EPSG:3044").name, "utm:32n");  // northing first, but not in point clouds
  EXPECT_EQ(NameCrs("EPSG:2056").name, "epsg:2056");
  EXPECT_EQ(NameCrs("EPSG:4326").name, "");
  EXPECT_EQ(NameCrs("EPSG:2227", 1200.0 / 3937.0).name, "epsg:2227 heights:us-ft");
  const NamedCrs above_geoid = NameCrs("EPSG:25832+7837");
  EXPECT_EQ(above_geoid.name, "utm:32n");
  EXPECT_EQ(above_geoid.epsg, 25832);
  EXPECT_TRUE(above_geoid.heights_from_geoid);
  EXPECT_NE(above_geoid.why_not.find("grid"), std::string::npos);
  EXPECT_TRUE(IsSameCrs("epsg:32632", "utm:32n"));
  EXPECT_FALSE(IsSameCrs("epsg:2056", "epsg:21781"));
  EXPECT_FALSE(IsSameCrs("utm:32n heights:ft", "utm:32n"));
}

// Text of ESRI has no codes. A projection of one's own has none at all.
TEST(CrsNames, WellKnownTextWithoutCodes) {
  const std::string geographic =
      R"(GEOGCS["GCS_North_American_1983",DATUM["D_North_American_1983",)"
      R"(SPHEROID["GRS_1980",6378137.0,298.257222101]],PRIMEM["Greenwich",0.0],)"
      R"(UNIT["Degree",0.0174532925199433]])";
  const auto albers = [&](double meridian_deg, double north_m) {
    return R"(PROJCS["NAD_1983_California_Teale_Albers",)" + geographic +
           R"(,PROJECTION["Albers"],PARAMETER["False_Easting",0.0],)"
           R"(PARAMETER["False_Northing",)" +
           std::to_string(north_m) + R"(],PARAMETER["Central_Meridian",)" +
           std::to_string(meridian_deg) +
           R"(],PARAMETER["Standard_Parallel_1",34.0],PARAMETER["Standard_Parallel_2",40.5],)"
           R"(PARAMETER["Latitude_Of_Origin",0.0],UNIT["Meter",1.0]])";
  };
  EXPECT_EQ(NameCrs(albers(-120.0, -4e6)).name, "epsg:3310");
  const NamedCrs own = NameCrs(albers(-119.0, -4.2e6));
  ASSERT_TRUE(own.name.starts_with("wkt:")) << own.name;
  EXPECT_EQ(ShownCrsName(own.name), "\"NAD83 / California Albers\"");
  const PointCrs crs(own.name, kSierra);
  const Vector3d p_c = crs.FromMap(Vector3d::Zero());
  EXPECT_NEAR(p_c.x(), 0.0, 1e-6);  // the origin of the frame is on the central meridian
  EXPECT_LT(crs.ToMap(p_c).norm(), 1e-6);
}

// PROJ makes one system with three axes of these, which has no code of its own.
TEST(CrsNames, EllipsoidalHeightsAsAVerticalSystem) {
  const std::string geographic =
      "GEOGCS[\"ETRS89\",DATUM[\"European_Terrestrial_Reference_System_1989\",SPHEROID[\"GRS "
      "1980\",6378137,298.257222101]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433],"
      "AUTHORITY[\"EPSG\",\"4258\"]]";
  const std::string utm =
      "PROJCS[\"ETRS89 / UTM zone 32N\"," + geographic +
      ",PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],PARAMETER["
      "\"central_meridian\",9],PARAMETER[\"scale_factor\",0.9996],PARAMETER[\"false_easting\","
      "500000],PARAMETER[\"false_northing\",0],UNIT[\"metre\",1],AUTHORITY[\"EPSG\",\"25832\"]]";
  const auto with_heights = [&](const std::string& unit) {
    return "COMPD_CS[\"c\"," + utm + ",VERT_CS[\"Ellipsoid\",VERT_DATUM[\"Ellipsoid\",2002],UNIT[" +
           unit + "]]]";
  };
  const NamedCrs metres = NameCrs(with_heights("\"metre\",1"), std::nullopt);
  EXPECT_EQ(metres.name, "utm:32n");
  EXPECT_FALSE(metres.heights_from_geoid);
  const std::string feet = NameCrs(with_heights("\"foot\",0.3048"), std::nullopt).name;
  EXPECT_TRUE(feet.ends_with(" heights:ft")) << feet;
}

TEST(CrsNames, PrjTextIsTheHorizontalPartInTheFormOfEsri) {
  const std::string utm = PrjText("utm:32n").value();
  EXPECT_TRUE(utm.starts_with("PROJCS[\"WGS_1984_UTM_Zone_32N\"")) << utm;
  EXPECT_EQ(NameCrs(utm).name, "utm:32n");
  EXPECT_EQ(NameCrs(PrjText("utm:60s").value()).name, "utm:60s");
  EXPECT_EQ(NameCrs(PrjText("epsg:2056").value()).name, "epsg:2056");
  EXPECT_EQ(PrjText("epsg:25832+7837"), PrjText("epsg:25832"));
  EXPECT_EQ(PrjText("epsg:2227 heights:us-ft"), PrjText("epsg:2227"));
  EXPECT_EQ(PrjText("map"), std::nullopt);
  EXPECT_EQ(PrjText("ecef"), std::nullopt);
  EXPECT_EQ(PrjText("epsg:999999"), std::nullopt);
}

TEST(PointCrs, Names) {
  for (const char* name : {"map", "ecef", "none", "utm:1n", "utm:60s", "epsg:2056",
                           "epsg:25832+7837", "epsg:2227 heights:us-ft", "wkt:PROJCS[]"}) {
    EXPECT_TRUE(IsPointCrsName(name)) << name;
  }
  for (const char* name : {"", "utm:0n", "utm:61n", "utm:11", "UTM:11n", "utm:11N", "4326",
                           "epsg:", "epsg:x", "epsg:25832+", "wkt:", "utm:11n heights:m"}) {
    EXPECT_FALSE(IsPointCrsName(name)) << name;
  }
  EXPECT_THROW(PointCrs("none", kSierra), InvalidConfig);
}

}  // namespace dn::geo_test
