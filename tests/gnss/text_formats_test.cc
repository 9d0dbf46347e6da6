#include <dn/geo/point_crs.h>
#include <dn/geo/text_table.h>
#include <dn/gnss/gnss_data.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn::gnss_test {

using testing::ExpectInvalid;
using testing::TempFile;

// The tolerance allows for the rounding of one product.
constexpr double kTextRounding = 1e-15;

GnssData ReadOdyn(const std::string& text) {
  const TempFile file("GPS.txt", text);
  return ReadGnss(file.path(), GnssFormat::kOdyn);
}

GnssData ReadObGins(const std::string& text) {
  const TempFile file("GNSS.pos", text);
  return ReadGnss(file.path(), GnssFormat::kObGins);
}

void ExpectDiagonal(const std::optional<Eigen::Matrix3d>& covariance,
                    const Eigen::Vector3d& sigma) {
  ASSERT_TRUE(covariance.has_value());
  const Eigen::Matrix3d expected = sigma.cwiseAbs2().asDiagonal();
  EXPECT_LE((*covariance - expected).norm(), kTextRounding);
}

TEST(OdynGnss, FourColumnsHaveNoSigmas) {
  const GnssData data =
      ReadOdyn("# t, lat, lon, h\n10, 46.5, -6.25, 500.5\n11, 46.5, -6.25, 501\n");
  ASSERT_EQ(data.epochs.size(), 2u);
  const GnssEpoch& epoch = data.epochs[0];
  EXPECT_EQ(epoch.t_s, 10.0);
  EXPECT_EQ(epoch.antenna.lat_rad, 46.5 * kRadPerDeg);
  EXPECT_EQ(epoch.antenna.lon_rad, -6.25 * kRadPerDeg);
  EXPECT_EQ(epoch.antenna.h_m, 500.5);
  EXPECT_EQ(epoch.line, 2);
  EXPECT_EQ(epoch.quality, 0);
  EXPECT_FALSE(epoch.covariance_enu_m2 || epoch.velocity_enu_mps || epoch.velocity_covariance_enu);
}

// A log of several sensors has rows without a new position.
TEST(OdynGnss, OnlyChangedPositionsOfALog) {
  const TempFile file("log.csv",
                      "t,wx,lat,lon,h\n0.1,1,0,0,0\n0.2,1,,,\n0.3,1,46.5,6.5,500\n"
                      "0.4,1,46.5,6.5,500\n0.5,1,nan,NaN,nan\n0.6,1,46.5,6.5,500.1\n"
                      "0.7,1,46.6,6.5,500.1\n");
  GnssColumns columns;
  columns.names = {"t", "skip", "lat", "lon", "h"};
  columns.only_changed = true;
  const GnssData data = ReadGnss(file.path(), GnssFormat::kOdyn, 0.0, columns);
  ASSERT_EQ(data.epochs.size(), 3u);
  EXPECT_EQ(data.epochs[0].t_s, 0.3);
  EXPECT_EQ(data.epochs[1].t_s, 0.6);
  EXPECT_EQ(data.epochs[2].line, 8);
  EXPECT_EQ(data.counts.at("gnss rows that repeat the position before, left out"), 1);
  columns.only_changed = false;
  ExpectInvalid([&] { ReadGnss(file.path(), GnssFormat::kOdyn, 0.0, columns); },
                "row has 4 columns, but `columns` names 5", 3);
  const TempFile broken("log.csv", "0.1,1,46.5,6.5,nan\n");
  columns.only_changed = true;
  ExpectInvalid([&] { ReadGnss(broken.path(), GnssFormat::kOdyn, 0.0, columns); },
                "'nan' is not a finite number", 1);
  const TempFile none("log.csv", "0.1,1,0,0,0\n0.2,1,0,0,0\n");
  ExpectInvalid([&] { ReadGnss(none.path(), GnssFormat::kOdyn, 0.0, columns); },
                "no row has a position", 0);
}

TEST(OdynGnss, SevenColumnsHavePositionSigmas) {
  const GnssEpoch epoch = ReadOdyn("10 46.5 6 500 0.01 0.02 0.03\n").epochs[0];
  ExpectDiagonal(epoch.covariance_enu_m2, {0.01, 0.02, 0.03});
  EXPECT_FALSE(epoch.velocity_enu_mps);
}

TEST(OdynGnss, TenColumnsHaveVelocity) {
  const GnssEpoch epoch = ReadOdyn("10 46.5 6 500 1 -2 3 0.1 0.2 0.3\n").epochs[0];
  EXPECT_FALSE(epoch.covariance_enu_m2);
  EXPECT_EQ(epoch.velocity_enu_mps, Eigen::Vector3d(1, -2, 3));
  ExpectDiagonal(epoch.velocity_covariance_enu, {0.1, 0.2, 0.3});
}

TEST(OdynGnss, ThirteenColumnsHaveAll) {
  const GnssEpoch epoch = ReadOdyn("10 46.5 6 500 0.01 0.02 0.03 1 -2 3 0.1 0.2 0.3\n").epochs[0];
  ExpectDiagonal(epoch.covariance_enu_m2, {0.01, 0.02, 0.03});
  EXPECT_EQ(epoch.velocity_enu_mps, Eigen::Vector3d(1, -2, 3));
  ExpectDiagonal(epoch.velocity_covariance_enu, {0.1, 0.2, 0.3});
}

const Geodetic kPlace{47.05 * kRadPerDeg, 8.3 * kRadPerDeg, 500.0};

std::string Row(double t_s, const Eigen::Vector3d& p, const std::string& rest) {
  std::string text = FormatDouble(t_s);
  for (const double x : p) text += ", " + FormatDouble(x);
  return text + rest + "\n";
}

void ExpectPlace(const GnssEpoch& epoch) {
  EXPECT_NEAR(epoch.antenna.lat_rad, kPlace.lat_rad, 1e-12);
  EXPECT_NEAR(epoch.antenna.lon_rad, kPlace.lon_rad, 1e-12);
  EXPECT_NEAR(epoch.antenna.h_m, kPlace.h_m, 1e-6);
}

TEST(OdynGnss, OtherCoordinatesAreDeclared) {
  const LocalFrame frame({47.0 * kRadPerDeg, 8.0 * kRadPerDeg, 300.0});
  for (const char* crs : {"utm:32n", "map", "ecef"}) {
    SCOPED_TRACE(crs);
    const Eigen::Vector3d p = PointCrs(crs, frame).FromMap(frame.ToMap(kPlace));
    const TempFile file("GPS.txt", Row(10, p, ""));
    const GnssColumns columns{TextCoordinates(crs, frame.origin(), "gnss.crs")};
    ExpectPlace(ReadGnss(file.path(), GnssFormat::kOdyn, 0.0, columns).epochs.at(0));
    const TempFile other("GNSS.pos", Row(10, p, ", 0.1, 0.1, 0.1"));
    ExpectPlace(ReadGnss(other.path(), GnssFormat::kObGins, 0.0, columns).epochs.at(0));
  }
}

// The two positions show one second of flight along grid north.
TEST(OdynGnss, VelocitiesOfAGridAreTurnedToTrueNorth) {
  const LocalFrame frame(kPlace);
  const PointCrs utm("utm:32n", frame);
  const Eigen::Vector3d from = utm.FromMap(Eigen::Vector3d::Zero());
  const Eigen::Vector3d moved_m = utm.ToMap(from + Eigen::Vector3d(0, 1, 0)).normalized();
  ASSERT_GT(std::abs(moved_m.x()), 0.005);
  const TempFile file("GPS.txt", Row(10, from, ", 0.1, 0.3, 0.5, 0, 1, 0, 0.1, 0.3, 0.5"));
  const GnssColumns grid{TextCoordinates("utm:32n", {}, "gnss.crs"), true};
  const GnssEpoch epoch = ReadGnss(file.path(), GnssFormat::kOdyn, 0.0, grid).epochs.at(0);
  EXPECT_LE((*epoch.velocity_enu_mps - moved_m).norm(), 1e-6);
  for (const auto& covariance : {epoch.covariance_enu_m2, epoch.velocity_covariance_enu}) {
    EXPECT_NEAR(std::sqrt(moved_m.dot(*covariance * moved_m)), 0.3, 1e-6);
    EXPECT_NEAR((*covariance)(2, 2), 0.25, 1e-12);
  }
}

TEST(OdynGnss, DegreesAreNoGrid) {
  const TempFile file("GPS.txt", "10, 47.05, 8.3, 500\n");
  const GnssColumns grid{TextCoordinates("utm:32n", {}, "gnss.crs")};
  ExpectInvalid([&] { ReadGnss(file.path(), GnssFormat::kOdyn, 0.0, grid); },
                "if these are degrees, set gnss.crs: geographic", 1);
}

TEST(OdynGnss, DropsRepeatsAndContinuesOverTheWeek) {
  const GnssData data = ReadOdyn("604799 46 6 500\n604799 46 6 500\n0 46 6 500\n1 46 6 500\n");
  EXPECT_EQ(data.repeated_rows_dropped, 1);
  ASSERT_EQ(data.epochs.size(), 3u);
  EXPECT_EQ(data.epochs[2].t_s, 604801.0);
  EXPECT_EQ(data.epochs[2].line, 4);
}

// A sigma of 0 is unknown. It must not become the default of a flight if other rows have sigmas.
TEST(Gnss, RowsWithUnknownSigmas) {
  for (const auto& read : {ReadOdyn, ReadObGins}) {
    const GnssData none = read("10 46 6 500 0 0 0\n11 46 6 500 0 0 0\n");
    ASSERT_EQ(none.epochs.size(), 2u);
    EXPECT_FALSE(none.epochs[0].covariance_enu_m2);
    EXPECT_TRUE(none.counts.empty());
    const GnssData some = read("10 46 6 500 1 1 1\n11 46 6 500 0 0 0\n12 46 6 500 1 1 1\n");
    ASSERT_EQ(some.epochs.size(), 2u);
    EXPECT_EQ(some.epochs[1].t_s, 12.0);
    EXPECT_EQ(some.counts.at("gnss rows with sigmas of 0, left out"), 1);
  }
}

TEST(Gnss, VelocitySigmasOfZeroAreUnknown) {
  const TempFile ten("ten.txt", "100 46 6 500 1 2 3 0 0 0\n101 46 6 500 1 2 3 .1 .1 .2\n");
  const GnssData odyn = ReadGnss(ten.path(), GnssFormat::kOdyn);
  EXPECT_FALSE(odyn.epochs[0].velocity_enu_mps || odyn.epochs[0].velocity_covariance_enu);
  EXPECT_TRUE(odyn.epochs[1].velocity_enu_mps.has_value());
  const TempFile thirteen("ob.txt", "100 46 6 500 1 2 3 .1 .1 .2 0 0 0\n");
  const GnssData ob_gins = ReadGnss(thirteen.path(), GnssFormat::kObGins);
  EXPECT_FALSE(ob_gins.epochs[0].velocity_enu_mps.has_value());
}

TEST(OdynGnss, RejectsBadFilesEachByItsOwnMessage) {
  const std::string ok = "10 46 6 500 0.1 0.1 0.1\n";
  ExpectInvalid([&] { ReadOdyn(ok + "11 46 6 500 0.1 0 0.1\n"); }, "position sigma N is zero", 2);
  ExpectInvalid([&] { ReadOdyn(ok + "11 46 6 500 0.1 1e-200 1\n"); },
                "position sigma N is 1e-200, must lie between 1e-9 and 1e9", 2);
  ExpectInvalid([&] { ReadOdyn(ok + "11 46 6 1e308 0.1 0.1 1\n"); },
                "height is 1e+308 m, must be within -1e6 and 1e6 m", 2);
  ExpectInvalid([] { ReadOdyn("11 46 6 500 0 1e300 0 1 1 1\n"); },
                "velocity is 1e+300 m/s, must be below 1e5", 1);
  ExpectInvalid([] { ReadObGins("11 46 6 500 1 1e300 0 1 1 1 1 1 1\n"); }, "velocity is", 1);
  ExpectInvalid([&] { ReadOdyn(ok + "11 46 6 500 0.1 0.1 -1\n"); }, "position sigma U is negative",
                2);
  ExpectInvalid([&] { ReadOdyn(ok + "11 46 6 500 inf 0.1 1\n"); }, "'inf' is not a finite", 2);
  ExpectInvalid([&] { ReadOdyn(ok + "11 46 6 nan 1 0.1 1\n"); }, "'nan' is not a finite", 2);
  ExpectInvalid([&] { ReadOdyn(ok + "11 90.1 6 500 1 1 1\n"); }, "latitude is 90.1", 2);
  ExpectInvalid([&] { ReadOdyn(ok + "11 46 -181 500 1 1 1\n"); }, "longitude is -181", 2);
  ExpectInvalid([&] { ReadOdyn(ok + "10 46 6 501 1 1 1\n"); }, "does not increase", 2);
  ExpectInvalid([&] { ReadOdyn(ok + "9 46 6 500 1 1 1\n"); }, "does not increase", 2);
  ExpectInvalid([&] { ReadOdyn(ok + "11 46 6 500\n"); }, "4 columns", 2);
  ExpectInvalid([&] { ReadOdyn("11 46 6 500 1 2\n"); }, "6 columns, must have 4, 7, 10 or 13", 1);
  ExpectInvalid([&] { ReadOdyn("11 46 6 500 1 2 3 0 1 1\n"); }, "velocity sigma E is zero", 1);
  ExpectInvalid([&] { ReadOdyn(""); }, "no rows", 0);
}

TEST(ObGinsGnss, SigmasAreNorthEastDown) {
  const GnssEpoch epoch = ReadObGins("456300.000 30.5 114.25 23.5 0.005 0.004 0.008\n").epochs[0];
  EXPECT_EQ(epoch.t_s, 456300.0);
  EXPECT_EQ(epoch.antenna.lon_rad, 114.25 * kRadPerDeg);
  ExpectDiagonal(epoch.covariance_enu_m2, {0.004, 0.005, 0.008});
  EXPECT_FALSE(epoch.velocity_enu_mps);
}

TEST(ObGinsGnss, ThirteenColumnsArePositionVelocityAndTheirSigmas) {
  const GnssEpoch epoch =
      ReadObGins("456300 30.5 114.25 23.5 1 2 3 0.005 0.004 0.008 0.05 0.04 0.08\n").epochs[0];
  ExpectDiagonal(epoch.covariance_enu_m2, {0.004, 0.005, 0.008});
  EXPECT_EQ(epoch.velocity_enu_mps, Eigen::Vector3d(2, 1, -3));
  ExpectDiagonal(epoch.velocity_covariance_enu, {0.04, 0.05, 0.08});
}

TEST(ObGinsGnss, RejectsBadFilesEachByItsOwnMessage) {
  ExpectInvalid([] { ReadObGins("1 30 114 23\n"); }, "4 columns, must have 7 or 13", 1);
  ExpectInvalid([] { ReadObGins("1 30 114 23 0 1 1\n"); }, "position sigma N is zero", 1);
  ExpectInvalid([] { ReadObGins("1 30 114 23 1 1 -1\n"); }, "position sigma D is negative", 1);
  ExpectInvalid([] { ReadObGins("1 30 114 23 1 1 1 1 1 1 1 -1 1\n"); },
                "velocity sigma E is negative", 1);
  ExpectInvalid([] { ReadObGins("1 -91 114 23 1 1 1\n"); }, "latitude is -91", 1);
}

struct RealFile {
  const char* folder;
  std::size_t rows;
  bool has_sigma;
  bool has_velocity;
};

class RealGnss : public ::testing::TestWithParam<RealFile> {};

// The speed between consecutive positions must be one that a helicopter or a slower vehicle can
// reach.
TEST_P(RealGnss, Reads) {
  const std::filesystem::path path =
      std::filesystem::path(DN_SHARED_DATA_DIR "/data") / GetParam().folder / "GPS.txt";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "real data absent: " << path;
  const GnssData data = ReadGnss(path, GnssFormat::kOdyn);
  ASSERT_EQ(data.epochs.size() + static_cast<std::size_t>(data.repeated_rows_dropped),
            GetParam().rows);
  constexpr double kMaxSpeedMps = 60.0;
  for (std::size_t i = 0; i < data.epochs.size(); ++i) {
    const GnssEpoch& epoch = data.epochs[i];
    EXPECT_EQ(epoch.covariance_enu_m2.has_value(), GetParam().has_sigma);
    EXPECT_EQ(epoch.velocity_enu_mps.has_value(), GetParam().has_velocity);
    if (i == 0) continue;
    const double moved_m = (ToEcef(epoch.antenna) - ToEcef(data.epochs[i - 1].antenna)).norm();
    EXPECT_LT(moved_m, kMaxSpeedMps * (epoch.t_s - data.epochs[i - 1].t_s));
  }
}

INSTANTIATE_TEST_SUITE_P(Shared, RealGnss,
                         ::testing::Values(RealFile{"heli-track", 2411, true, false},
                                           RealFile{"psins-car", 100, true, false},
                                           RealFile{"thor75", 670, false, true},
                                           RealFile{"walk", 536, true, true}),
                         [](const auto& param_info) {
                           std::string name = param_info.param.folder;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace dn::gnss_test
