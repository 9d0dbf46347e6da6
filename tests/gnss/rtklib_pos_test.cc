#include <dn/gnss/gnss_data.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <string>

#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn::gnss_test {

using testing::ExpectInvalid;
using testing::TempFile;

constexpr double kRounding = 1e-15;

const std::string kPreamble =
    "% program   : RTKPOST ver.2.4.3\n"
    "% inp file  : rover.obs\n"
    "%\n"
    "% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix,2:float,3:sbas,4:dgps,5:single,6:ppp,ns=# of "
    "satellites)\n";
const std::string kSigmas =
    "   Q  ns   sdn(m)   sde(m)   sdu(m)  sdne(m)  sdeu(m)  sdun(m) age(s)  ratio";
const std::string kLlh = "  latitude(deg) longitude(deg)  height(m)" + kSigmas;
const std::string kVelocity =
    "    vn(m/s)    ve(m/s)    vu(m/s)      sdvn     sdve     sdvu    sdvne    sdveu    sdvun";
const std::string kGpst = "%  GPST                ";
const std::string kQuality =
    "   1   9   0.0200   0.0100   0.0500  -0.0060   0.0080   0.0150   0.00    4.2";

GnssData ReadRtklib(const std::string& text) {
  const TempFile file("rover.pos", text);
  return ReadGnss(file.path(), GnssFormat::kRtklib);
}

GnssEpoch ReadOne(const std::string& text) { return ReadRtklib(text).epochs.at(0); }

// The signed roots s give covariances c = s |s|; the columns are north-east, east-up, up-north.
Eigen::Matrix3d ExpectedCovarianceEnu() {
  const double ne = -0.006 * 0.006, eu = 0.008 * 0.008, un = 0.015 * 0.015;
  Eigen::Matrix3d C;
  C << 0.01 * 0.01, ne, eu, ne, 0.02 * 0.02, un, eu, un, 0.05 * 0.05;
  return C;
}

TEST(RtklibPos, ReadsGeodeticCoordinatesAndSignedRoots) {
  const GnssEpoch epoch =
      ReadOne(kPreamble + kGpst + kLlh + "\n" +
              "2024/03/12 13:45:30.250   46.123456789    6.987654321   512.3456" + kQuality + "\n");
  // 2024-03-12 is a Tuesday, two days into the week.
  EXPECT_EQ(epoch.t_s, 2 * 86400 + 13 * 3600 + 45 * 60 + 30.25);
  EXPECT_EQ(epoch.antenna.lat_rad, 46.123456789 * kRadPerDeg);
  EXPECT_EQ(epoch.antenna.lon_rad, 6.987654321 * kRadPerDeg);
  EXPECT_EQ(epoch.antenna.h_m, 512.3456);
  EXPECT_EQ(epoch.quality, 1);
  EXPECT_EQ(epoch.line, 6);
  ASSERT_TRUE(epoch.covariance_enu_m2);
  EXPECT_LE((*epoch.covariance_enu_m2 - ExpectedCovarianceEnu()).norm(), kRounding);
  EXPECT_FALSE(epoch.velocity_enu_mps);
}

TEST(RtklibPos, ReadsWeekAndSeconds) {
  const GnssData data = ReadRtklib(kGpst + kLlh + "\n" +                                        //
                                   "2305 604799.500   46.1    6.9   512.3" + kQuality + "\n" +  //
                                   "2306      0.500   46.1    6.9   512.3" + kQuality + "\n");
  ASSERT_EQ(data.epochs.size(), 2u);
  EXPECT_EQ(data.epochs[0].t_s, 604799.5);
  EXPECT_EQ(data.epochs[1].t_s, 604800.5);
}

TEST(RtklibPos, ContinuesCalendarTimesOverTheWeek) {
  const GnssData data =
      ReadRtklib(kGpst + kLlh + "\n" +  //
                 "2024/03/16 23:59:59.000   46.1    6.9   512.3" + kQuality + "\n" +
                 "2024/03/17 00:00:01.000   46.1    6.9   512.3" + kQuality + "\n");
  EXPECT_EQ(data.epochs.at(1).t_s, 604801.0);
}

struct TimeCase {
  const char* label;
  const char* time;
  double t_s;
};

class RtklibTime : public ::testing::TestWithParam<TimeCase> {};

TEST_P(RtklibTime, IsTurnedIntoGpsTime) {
  const GnssEpoch epoch = ReadOne(std::string("%  ") + GetParam().label + "   " + kLlh + "\n" +
                                  GetParam().time + "   46.1    6.9   512.3" + kQuality + "\n");
  EXPECT_EQ(epoch.t_s, GetParam().t_s);
}

INSTANTIATE_TEST_SUITE_P(
    Labels, RtklibTime,
    ::testing::Values(TimeCase{"GPST", "2024/03/12 00:00:00.000", 172800.0},
                      TimeCase{"UTC", "2024/03/12 00:00:00.000", 172818.0},
                      TimeCase{"UTC", "2305 172800.000", 172818.0},
                      // The GPS week ends while UTC is still 18 s before midnight.
                      TimeCase{"UTC", "2024/03/16 23:59:50.000", 8.0},
                      TimeCase{"JST", "2024/03/12 09:00:00.000", 172818.0},
                      // There were 16 leap seconds before July 2015 and 17 before 2017.
                      TimeCase{"UTC", "2015/06/30 23:59:59.000", 2 * 86400 + 86399 + 16.0},
                      TimeCase{"UTC", "2015/07/01 00:00:00.000", 3 * 86400 + 17.0},
                      TimeCase{"UTC", "2016/12/31 00:00:00.000", 6 * 86400 + 17.0}),
    [](const auto& tested) {
      std::string name = std::string(tested.param.label) + "_" + tested.param.time;
      std::replace_if(
          name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
      return name;
    });

TEST(RtklibPos, ReadsDegreesMinutesSeconds) {
  const std::string header =
      kGpst + " latitude(d'\")   longitude(d'\")  height(m)" + kSigmas + "\n";
  const GnssEpoch epoch =
      ReadOne(header + "2305 100.000  -0 30 36.00000    6 15 18.00000   512.3" + kQuality + "\n");
  EXPECT_NEAR(epoch.antenna.lat_rad, -0.51 * kRadPerDeg, kRounding);
  EXPECT_NEAR(epoch.antenna.lon_rad, 6.255 * kRadPerDeg, kRounding);
  EXPECT_EQ(epoch.antenna.h_m, 512.3);
}

TEST(RtklibPos, ReadsOtherSeparators) {
  std::string text = kGpst + kLlh + "\n2305 100.000   46.1    6.9   512.3" + kQuality + "\n";
  for (std::size_t at; (at = text.find("  ", 3)) != std::string::npos;) text.replace(at, 2, ",");
  EXPECT_EQ(ReadOne(text).antenna.h_m, 512.3);
}

// At latitude 0 and longitude 90 deg, east is -x, north is z, and up is y.
TEST(RtklibPos, TurnsEcefIntoEastNorthUp) {
  const std::string header =
      kGpst +
      "     x-ecef(m)      y-ecef(m)      z-ecef(m)   Q  ns   sdx(m)   sdy(m)   sdz(m)  sdxy(m)  "
      "sdyz(m)  sdzx(m) age(s)  ratio   vx(m/s)    vy(m/s)    vz(m/s)    sdvx     sdvy     sdvz    "
      "sdvxy    sdvyz    sdvzx\n";
  const GnssEpoch epoch = ReadOne(
      header +
      "2305 100.000  0.0000  6378237.0000  0.0000  2  9  0.0300  0.0500  0.0200  0.0100  -0.0100  "
      "0.0150  0.00  1.5   1.0  2.0  3.0   0.1  0.2  0.3  0.0  0.0  0.0\n");
  EXPECT_NEAR(epoch.antenna.lat_rad, 0.0, kRounding);
  EXPECT_NEAR(epoch.antenna.lon_rad, 90 * kRadPerDeg, kRounding);
  EXPECT_NEAR(epoch.antenna.h_m, 100.0, 1e-8);
  EXPECT_EQ(epoch.quality, 2);
  const double xy = 1e-4, yz = -1e-4, zx = 2.25e-4;
  Eigen::Matrix3d expected;
  expected << 9e-4, -zx, -xy, -zx, 4e-4, yz, -xy, yz, 25e-4;
  EXPECT_LE((*epoch.covariance_enu_m2 - expected).norm(), kRounding);
  EXPECT_LE((*epoch.velocity_enu_mps - Eigen::Vector3d(-1, 3, 2)).norm(), 1e-14);
  const Eigen::Vector3d variances(0.01, 0.09, 0.04);
  EXPECT_LE((epoch.velocity_covariance_enu->diagonal() - variances).norm(), kRounding);
}

TEST(RtklibPos, ReadsVelocities) {
  const std::string row = "2305 100.000   46.1    6.9   512.3" + kQuality;
  const GnssEpoch epoch =
      ReadOne(kGpst + kLlh + kVelocity + "\n" + row + " 1 2 3 0.2 0.1 0.3 0.05 0 -0.06\n");
  EXPECT_EQ(epoch.velocity_enu_mps, Eigen::Vector3d(2, 1, 3));
  Eigen::Matrix3d expected;
  expected << 0.01, 0.0025, 0, 0.0025, 0.04, -0.0036, 0, -0.0036, 0.09;
  EXPECT_LE((*epoch.velocity_covariance_enu - expected).norm(), kRounding);

  const GnssEpoch none = ReadOne(kGpst + kLlh + kVelocity + "\n" + row + " 0 0 0 0 0 0 0 0 0\n");
  EXPECT_FALSE(none.velocity_enu_mps || none.velocity_covariance_enu);
}

// Two correlations of +1 and one of -1 cannot exist together: the sigmas stay, the correlations
// shrink.
TEST(RtklibPos, RepairsIndefiniteCovariances) {
  const GnssEpoch epoch =
      ReadOne(kGpst + kLlh + "\n2305 100.000   46.1    6.9   512.3" +
              "   5   9   1.0000   1.0000   1.0000  1.0000   1.0000  -1.0000   0.00    0.0\n");
  const Eigen::Matrix3d& C = *epoch.covariance_enu_m2;
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(C).eigenvalues()[0], 0.9e-3);
  EXPECT_LE((C.diagonal() - Eigen::Vector3d::Ones()).norm(), kRounding);
  EXPECT_GT(C(0, 1), 0.4);
  EXPECT_LT(C(1, 2), -0.4);
  EXPECT_EQ(C, C.transpose());
}

TEST(RtklibPos, DropsRepeats) {
  const std::string row = "2305 100.000   46.1    6.9   512.3" + kQuality + "\n";
  const GnssData data = ReadRtklib(kGpst + kLlh + "\n" + row + row);
  EXPECT_EQ(data.epochs.size(), 1u);
  EXPECT_EQ(data.repeated_rows_dropped, 1);
}

// Real-time programs write the rows without header lines.
TEST(RtklibPos, ReadsCompleteRowsWithoutHeader) {
  const std::string velocity = "  0.1 0.2 0.3 0.01 0.02 0.03 0.001 0 0";
  const std::string place = " 46.123456789 6.987654321 512.3456", xyz = " 4396000 538000 4575500";
  const auto same = [&](const std::string& header, const std::string& row) {
    const GnssData with = ReadRtklib(header + "\n" + row + "\n");
    const GnssData without = ReadRtklib(row + "\n" + row + "\n");
    EXPECT_EQ(without.counts.at("gnss rows without a header, read as GPS time"), 2);
    EXPECT_TRUE(with.counts.empty());
    const GnssEpoch &a = with.epochs.at(0), &b = without.epochs.at(0);
    EXPECT_EQ(a.t_s, b.t_s);
    EXPECT_EQ(a.antenna.lat_rad, b.antenna.lat_rad);
    EXPECT_EQ(a.antenna.h_m, b.antenna.h_m);
    EXPECT_EQ(*a.covariance_enu_m2, *b.covariance_enu_m2);
    EXPECT_EQ(a.velocity_enu_mps, b.velocity_enu_mps);
    EXPECT_EQ(a.quality, b.quality);
  };
  const std::string xyz_header = kGpst +
                                 "x-ecef(m) y-ecef(m) z-ecef(m) Q ns sdx(m) sdy(m) sdz(m) sdxy(m) "
                                 "sdyz(m) sdzx(m) age(s) ratio";
  same(kGpst + kLlh, "2024/02/10 01:02:03.5" + place + kQuality);
  same(kGpst + kLlh, "2305 100.500" + place + kQuality);
  same(kGpst + kLlh + kVelocity, "2024/02/10 01:02:03.5" + place + kQuality + velocity);
  same(xyz_header, "2024/02/10 01:02:03.5" + xyz + kQuality);
  same(xyz_header + " vx vy vz sdvx sdvy sdvz sdvxy sdvyz sdvzx",
       "2024/02/10 01:02:03.5" + xyz + kQuality + velocity);
  ExpectInvalid([&] { ReadRtklib("2305 100.500" + place + " 1 9\n"); }, "out-outhead on", 1);
}

TEST(RtklibPos, AByteOrderMarkDoesNoHarm) {
  EXPECT_EQ(ReadRtklib("\xEF\xBB\xBF" + kPreamble + kGpst + kLlh + "\n2305 1.0 46 6.9 512" +
                       kQuality + "\n")
                .epochs.size(),
            1u);
}

TEST(RtklibPos, RowsWithUnknownSigmas) {
  const std::string header = kGpst + kLlh + "\n", zero = " 5 9 0 0 0 0 0 0 0.00 4.2\n";
  const GnssData some =
      ReadRtklib(header + "2305 1.0 46 6.9 512" + kQuality + "\n2305 2.0 46 6.9 512" + zero);
  EXPECT_EQ(some.epochs.size(), 1u);
  EXPECT_EQ(some.counts.at("gnss rows with sigmas of 0, left out"), 1);
  const GnssData none =
      ReadRtklib(header + "2305 1.0 46 6.9 512" + zero + "2305 2.0 46 6.9 512" + zero);
  EXPECT_EQ(none.epochs.size(), 2u);
  EXPECT_FALSE(none.epochs[0].covariance_enu_m2);
}

TEST(RtklibPos, RejectsBadRowsEachByItsOwnMessage) {
  const std::string header = kGpst + kLlh + "\n";
  const std::string sigmas_to_ratio = " 0.02 0.01 0.05 0 0 0 0.00 4.2\n";
  const auto row = [&](const std::string& time_and_place) {
    return [=] { ReadRtklib(header + time_and_place + " 1 9" + sigmas_to_ratio); };
  };
  ExpectInvalid(row("2305 1.0 91 6.9 512"), "latitude is 91", 2);
  ExpectInvalid(row("2305 1.0 46 400 512"), "longitude is 400", 2);
  ExpectInvalid(row("2305 1.0 46 6.9 nan"), "'nan' is not a finite", 2);
  ExpectInvalid(row("2305 1.0 46 6.9"), "row has 14 values, but the header names 15", 2);
  ExpectInvalid(row("2024/02/30 00:00:00 46 6.9 512"), "no such date", 2);
  ExpectInvalid(row("2024/02/10 24:00:00 46 6.9 512"), "no such time of day", 2);
  ExpectInvalid(row("1979/02/10 00:00:00 46 6.9 512"), "before the GPS epoch", 2);
  ExpectInvalid(row("2024/02 00:00:00 46 6.9 512"), "neither year/month/day", 2);
  ExpectInvalid(row("2024/x/10 00:00:00 46 6.9 512"), "'x' is not an integer", 2);
  ExpectInvalid(row("4294969320/02/10 00:00:00 46 6.9 512"), "not part of a date", 2);
  ExpectInvalid(row("2024/-2/10 00:00:00 46 6.9 512"), "not part of a date", 2);
  ExpectInvalid(row("9223372036854775807 1.0 46 6.9 512"), "outside 0 to", 2);
  ExpectInvalid(row("-1 1.0 46 6.9 512"), "GPS week -1", 2);
  ExpectInvalid(row("23.5 1.0 46 6.9 512"), "'23.5' is not an integer", 2);
  ExpectInvalid(
      [&] { ReadRtklib(header + "2305 1.0 46 6.9 512 1 9 0.02 0 0.05 0 0 0 0.00 4.2\n"); },
      "position sigma E is zero", 2);
  ExpectInvalid(
      [&] { ReadRtklib(header + "2305 1.0 46 6.9 512 1 9 -0.02 1 0.05 0 0 0 0.00 4.2\n"); },
      "position sigma N is negative", 2);
}

TEST(RtklibPos, RejectsQualitiesThatAreNoNumbersOfASolution) {
  const auto quality = [](const std::string& value) {
    return [=] {
      ReadRtklib(kGpst + kLlh + "\n2305 1.0 46 6.9 512 " + value +
                 " 9 0.02 0.01 0.05 0 0 0 0.00 4.2\n");
    };
  };
  for (const char* value : {"1e11", "-1", "1.5", "256"}) {
    ExpectInvalid(quality(value), "quality Q", 2);
  }
}

TEST(RtklibPos, RejectsTimesThatDoNotIncrease) {
  const auto file = [](const std::string& first, const std::string& second) {
    return [=] {
      ReadRtklib(kGpst + kLlh + "\n" + first + " 46.1 6.9 512.3" + kQuality + "\n" + second +
                 " 46.1 6.9 513.3" + kQuality + "\n");
    };
  };
  ExpectInvalid(file("2305 100.0", "2305 100.0"), "does not increase", 3);
  ExpectInvalid(file("2305 100.0", "2305 99.0"), "does not increase", 3);
  ExpectInvalid(file("2305 500000.0", "2305 10.0"), "does not increase", 3);
}

TEST(RtklibPos, RejectsFilesItCannotPlace) {
  const std::string row = "2305 1.0 46 6.9 512" + kQuality + "\n";
  ExpectInvalid([&] { ReadRtklib("2305 1.0 46 6.9 512 1 9\n"); },
                "no line with the names of the columns", 1);
  ExpectInvalid([&] { ReadRtklib(kPreamble + kGpst + kLlh + "\n"); }, "no solutions", 0);
  ExpectInvalid([&] { ReadRtklib(""); }, "no solutions", 0);
  ExpectInvalid(
      [&] { ReadRtklib(kGpst + "e-baseline(m) n-baseline(m) u-baseline(m) Q ns\n" + row); },
      "neither latitude", 1);
  ExpectInvalid(
      [&] {
        ReadRtklib("% (lat/lon/height=WGS84/geodetic,Q=1:fix)\n" + kGpst + kLlh + "\n" + row);
      },
      "ellipsoidal", 1);
  ExpectInvalid([&] { ReadRtklib(kGpst + kLlh + "\n" + row + kGpst + kLlh + kVelocity + "\n"); },
                "columns change", 3);
}

TEST(RtklibPos, RejectsBaselinesWithoutAHeader) {
  const std::string rest = " 1 12 0.015 0.015 0.03 0 0 0 0.00 25.0\n";
  for (const double step : {0.4, -1.5}) {
    std::string text;
    for (int i = 0; i < 5; ++i) {
      text += "2023/09/21 09:50:0" + std::to_string(i) + ".000 " + std::to_string(20.0 + step * i) +
              " 0.5 1.0" + rest;
    }
    const TempFile file("baselines.pos", text);
    ExpectInvalid([&] { ReadGnss(file.path(), GnssFormat::kRtklib); }, "baselines in m", 1);
  }
}

}  // namespace dn::gnss_test
