// Texts as sensors and programs write them: the content decides on kind, columns, units and clock.
#include <dn/files/file_content.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "inertial_rows.h"

namespace dn::files_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(ContentColumns, InertialDataInAnyOrder) {
  const auto usual = [](double t, const Row& w, const Row& f) {
    return Plus(Plus({381000 + t}, w), f);
  };
  EXPECT_THAT(Inspect(Inertial(usual)).columns, IsEmpty());
  const FileContent accel_first = Inspect(Inertial(
      [](double t, const Row& w, const Row& f) { return Plus(Plus({381000 + t}, f), w); }));
  EXPECT_EQ(accel_first.kind, FileKind::kImu);
  EXPECT_THAT(accel_first.columns, ElementsAre("t", "fx", "fy", "fz", "wx", "wy", "wz"));
  EXPECT_THAT(accel_first.why, HasSubstr("rates in columns 5-7 and forces in columns 2-4"));
  // A magnetometer follows, the forces are in g and the rates in deg/s.
  const FileContent nine = Inspect(Inertial([](double t, const Row& w, const Row& f) {
    return Plus(Plus(Plus({1694908782 + 381000 + t}, Times(f, 1 / 9.80665)), Times(w, 57.3)),
                {22, 5, -43});
  }));
  EXPECT_EQ(nine.kind, FileKind::kImu);
  EXPECT_THAT(nine.columns, ElementsAre("t", "fx", "fy", "fz", "wx", "wy", "wz"));
  EXPECT_TRUE(nine.forces_in_g && nine.rates_in_deg);
  EXPECT_EQ(nine.time_offset_s, 1694908782.0);
  // A magnetometer of unit length must not be taken for forces in g.
  const FileContent unit = Inspect(Inertial([](double t, const Row& w, const Row& f) {
    return Plus(Plus(Plus({381000 + t}, {0.6, 0.0, 0.8}), f), w);
  }));
  EXPECT_THAT(unit.columns,
              ElementsAre("t", "skip", "skip", "skip", "fx", "fy", "fz", "wx", "wy", "wz"));
  const FileContent weeks = Inspect(
      Inertial([&](double t, const Row& w, const Row& f) { return Plus({2280}, usual(t, w, f)); }));
  EXPECT_THAT(weeks.columns, ElementsAre("week", "t", "wx", "wy", "wz", "fx", "fy", "fz"));
  const FileContent milliseconds = Inspect(Inertial(
      [](double t, const Row& w, const Row& f) { return Plus(Plus({1e3 * (381000 + t)}, w), f); }));
  EXPECT_THAT(milliseconds.columns, ElementsAre("t_ms", "wx", "wy", "wz", "fx", "fy", "fz"));
}

TEST(ContentColumns, InertialDataByTheirHeader) {
  const auto rates_first = [](double t, const Row& w, const Row& f) {
    return Plus(Plus({381000 + t}, w), f);
  };
  const std::string rows = Inertial(rates_first);
  for (const char* header :
       {"time (sec),gyro_x (rad/s),gyro_y (rad/s),gyro_z (rad/s),accel_x (m/s^2),accel_y "
        "(m/s^2),accel_z (m/s^2)\n",
        "%time,field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z,"
        "field.linear_acceleration.x,field.linear_acceleration.y,field.linear_acceleration.z\n",
        "timestamp,wx,wy,wz,ax,ay,az\n", "Time,Gyr_X,Gyr_Y,Gyr_Z,Acc_X,Acc_Y,Acc_Z,\n",
        "\"t\",\"GyroX\",\"GyroY\",\"GyroZ\",\"AccX\",\"AccY\",\"AccZ\"\n",
        "% IMU of the second flight\nTOW [s],omega x,omega y,omega z,force x,force y,force z\n",
        "\xEF\xBB\xBFtime,gx,gy,gz,ax,ay,az\ns,rad/s,rad/s,rad/s,m/s2,m/s2,m/s2\n"}) {
    SCOPED_TRACE(header);
    const FileContent content = Inspect(header + rows);
    EXPECT_EQ(content.kind, FileKind::kImu) << content.why;
    EXPECT_THAT(content.columns, ElementsAre("t", "wx", "wy", "wz", "fx", "fy", "fz"));
    EXPECT_FALSE(content.rates_in_deg || content.forces_in_g);
  }
  // Names decide between columns that look alike, and units in names on slow rates.
  const FileContent named = Inspect(
      "SampleTimeFine,Euler_X,Euler_Y,Euler_Z,Acc_X,Acc_Y,Acc_Z,Gyr_X (deg/s),Gyr_Y (deg/s),Gyr_Z "
      "(deg/s),Mag_X,Mag_Y,Mag_Z,\n" +
      Inertial([](double t, const Row& w, const Row& f) {
        return Plus(Plus(Plus({677583000 + std::round(1e6 * t), -2.6, 5.6, -150.9}, f), w),
                    {-0.4, -0.5, -1.0});
      }));
  EXPECT_EQ(named.kind, FileKind::kImu) << named.why;
  EXPECT_THAT(named.columns,
              ElementsAre("t_us", "skip", "skip", "skip", "fx", "fy", "fz", "wx", "wy", "wz"));
  EXPECT_TRUE(named.rates_in_deg);
}

TEST(ContentColumns, GravityMustBeThere) {
  const FileContent removed = Inspect(Inertial([](double t, const Row& w, const Row& f) {
    const double burst = std::sin(0.7 * t) > 0.3 ? 2.5 : 0.2;
    return Plus(Plus({381000 + t}, w), {burst * f[0], burst * f[1], burst * (f[2] + 9.81)});
  }));
  EXPECT_EQ(removed.kind, FileKind::kUnknown);
  EXPECT_THAT(removed.why, HasSubstr("inertial data, but"));
  const FileContent reversed = Inspect(Inertial([](double t, const Row& w, const Row& f) {
    return Plus(Plus({381000 + t}, w), Times(f, -1.0));
  }));
  EXPECT_EQ(reversed.kind, FileKind::kImu);
}

TEST(ContentColumns, ATimeThatStandsIsNamed) {
  const FileContent content = Inspect(
      Inertial([](double, const Row& w, const Row& f) { return Plus(Plus({1.69491e9}, w), f); }));
  EXPECT_EQ(content.kind, FileKind::kUnknown);
  EXPECT_THAT(content.why, HasSubstr("no time that increases"));
}

/// Returns rows at 1 Hz of a flight to the north-east: time and position, then more.
std::string Positions(const std::function<Row(double t, double lat, double lon, double h)>& row,
                      double lat = 46.5, double lon = 6.5, const char* separator = " ") {
  std::string text;
  for (int i = 0; i < 120; ++i) {
    const double turn = 0.0006 * std::sin(0.05 * i);
    text += Join(row(381000 + i, lat + 0.0004 * i, lon + turn, 500 + 0.1 * i), separator);
  }
  return text;
}

TEST(ContentColumns, GnssWithWeeksAndUnknownSigmas) {
  const FileContent weeks = Inspect(Positions([](double t, double lat, double lon, double h) {
    return Row{2280, t, lat, lon, h, 0.015, 0.015, 0.03};
  }));
  EXPECT_EQ(weeks.kind, FileKind::kGnss) << weeks.why;
  EXPECT_THAT(weeks.columns,
              ElementsAre("week", "t", "lat", "lon", "h", "sigma_e", "sigma_n", "sigma_u"));
  EXPECT_TRUE(weeks.has_sigma);
  const FileContent zero = Inspect(Positions(
      [](double t, double lat, double lon, double h) { return Row{t, lat, lon, h, 0, 0, 0}; }));
  EXPECT_EQ(zero.kind, FileKind::kGnss) << zero.why;
  EXPECT_FALSE(zero.has_sigma);
  const FileContent more = Inspect(Positions(
      [](double t, double lat, double lon, double h) { return Row{t, lat, lon, h, 4, 12}; }));
  EXPECT_EQ(more.kind, FileKind::kGnss) << more.why;
  EXPECT_THAT(more.columns, ElementsAre("t", "lat", "lon", "h"));
}

TEST(ContentColumns, GnssByItsHeader) {
  const std::string named =
      "GPS TOW (s),GPS Week,Longitude (deg),Latitude (deg),Ellipsoid Height (m),East Velocity "
      "(m/s),North Velocity (m/s),Up Velocity (m/s)\n" +
      Positions([](double t, double lat, double lon, double h) {
        return Row{t, 2323, lon, lat, h, 0.1, 45, 0.1};
      });
  const FileContent content = Inspect(named);
  EXPECT_EQ(content.kind, FileKind::kGnss) << content.why;
  EXPECT_THAT(content.columns, ElementsAre("t", "week", "lon", "lat", "h"));
  const FileContent sigmas = Inspect("% time  lat  lon  height  sdn  sde  sdu\n" +
                                     Positions([](double t, double lat, double lon, double h) {
                                       return Row{t, lat, lon, h, 0.01, 0.02, 0.03};
                                     }));
  EXPECT_EQ(sigmas.kind, FileKind::kGnss) << sigmas.why;
  EXPECT_THAT(sigmas.columns, ElementsAre("t", "lat", "lon", "h", "sigma_n", "sigma_e", "sigma_u"));
  // A height above the sea is not above the ellipsoid.
  const FileContent sea = Inspect("time,latitude,longitude,altitude_above_seaLevel(meters)\n" +
                                  Positions(
                                      [](double t, double lat, double lon, double h) {
                                        return Row{t, lat, lon, h};
                                      },
                                      46.5, 6.5, ","));
  EXPECT_THAT(sea.why, HasSubstr("above the sea"));
}

// A file of millions of such lines once took gigabytes.
TEST(ContentColumns, TheSearchForTheFirstRowEnds) {
  std::string text;
  for (int i = 0; i < 12000; ++i) text += "1,2\n";
  text += Positions(
      [](double t, double lat, double lon, double h) {
        return Row{t, lat, lon, h};
      },
      46.5, 6.5, ",");
  const FileContent content = Inspect(text);
  EXPECT_EQ(content.kind, FileKind::kUnknown) << content.why;
  EXPECT_THAT(content.why, HasSubstr("2 columns"));
}

TEST(ContentColumns, TheAntimeridianAndThePole) {
  const auto row = [](double t, double lat, double lon, double h) {
    return Row{t, lat, std::remainder(lon, 360.0), h};
  };
  EXPECT_EQ(Inspect(Positions(row, -16.85, 180.0)).kind, FileKind::kGnss);
  EXPECT_EQ(Inspect(Positions(row, -16.85, -180.0)).kind, FileKind::kGnss);
  const auto full = [](double t, double lat, double lon, double h) {
    return Row{t, lat, lon < 0 ? lon + 360.0 : lon, h};
  };
  EXPECT_EQ(Inspect(Positions(full, 51.0, 0.0)).kind, FileKind::kGnss);
  EXPECT_EQ(Inspect(Positions(full, -16.85, 180.0)).kind, FileKind::kGnss);
  const auto polar = [](double t, double lat, double lon, double h) {
    const double north = 90.0 - lat;  // over the pole and on
    return Row{t, 90.0 - std::abs(north), north > 0 ? lon : lon - 180.0, h};
  };
  EXPECT_EQ(Inspect(Positions(polar, 89.98, 100.0)).kind, FileKind::kGnss);
  const auto south = [&](double t, double lat, double lon, double h) {
    Row mirrored = polar(t, lat, lon, h);
    mirrored[1] = -mirrored[1];
    return mirrored;
  };
  EXPECT_EQ(Inspect(Positions(south, 89.98, 100.0)).kind, FileKind::kGnss);
}

TEST(ContentColumns, LongitudeBeforeLatitude) {
  const FileContent content = Inspect(Positions(
      [](double t, double lat, double lon, double h) {
        return Row{t, lon, lat, h};
      },
      35.2, 136.9));
  EXPECT_EQ(content.kind, FileKind::kGnss) << content.why;
  EXPECT_THAT(content.columns, ElementsAre("t", "lon", "lat", "h"));
  EXPECT_THAT(content.why, HasSubstr("longitude comes before the latitude"));
}

/// Returns poses of a level body (FRD) on a winding course; `order` puts the quaternion.
std::string Poses(const std::function<Row(double w, double x, double y, double z)>& order,
                  const std::string& header = "", bool in_japan = false) {
  std::string text = header;
  double north_m = 0.0, east_m = 0.0;
  for (int i = 0; i < 600; ++i) {
    const double heading = 0.7 + 1.5 * std::sin(0.01 * i);
    north_m += 6.0 * std::cos(heading);
    east_m += 6.0 * std::sin(heading);
    const double roll = 0.1 * std::sin(0.05 * i), cr = std::cos(roll / 2), sr = std::sin(roll / 2);
    const double ch = std::cos(heading / 2), sh = std::sin(heading / 2);
    // Latitude first, or the longitude of a place where it exceeds 90 deg.
    const double lat = (in_japan ? 35.2 : 46.5) + north_m / 111000;
    const double lon = (in_japan ? 136.9 : 6.5) + east_m / (in_japan ? 91000 : 76000);
    Row row{381000 + 0.1 * i, in_japan ? lon : lat, in_japan ? lat : lon, 600};
    text += Join(Plus(row, order(cr * ch, sr * ch, sr * sh, cr * sh)), " ");
  }
  return text;
}

TEST(ContentColumns, QuaternionsInAnyOrder) {
  struct Case {
    std::function<Row(double, double, double, double)> order;
    ColumnNames columns;
  };
  const std::vector<Case> cases{{[](double w, double x, double y, double z) {
                                   return Row{w, x, y, z};
                                 },
                                 {}},
                                {[](double w, double x, double y, double z) {
                                   return Row{-w, -x, -y, -z};
                                 },
                                 {}},
                                {[](double w, double x, double y, double z) {
                                   return Row{x, y, z, w};
                                 },
                                 {"t", "lat", "lon", "h", "qx", "qy", "qz", "qw"}},
                                {[](double w, double x, double y, double z) {
                                   return Row{w, -x, -y, -z};
                                 },
                                 {"t", "lat", "lon", "h", "qw", "-qx", "-qy", "-qz"}},
                                {[](double w, double x, double y, double z) {
                                   return Row{-x, -y, -z, w};
                                 },
                                 {"t", "lat", "lon", "h", "-qx", "-qy", "-qz", "qw"}}};
  for (const Case& each : cases) {
    SCOPED_TRACE(FormatColumnNames(each.columns));
    const FileContent content = Inspect(Poses(each.order));
    EXPECT_EQ(content.kind, FileKind::kTrajectory) << content.why;
    EXPECT_EQ(content.columns, each.columns);
    EXPECT_EQ(content.trajectory->attitude, TrajectoryColumns::Attitude::kQuaternionNed);
    EXPECT_FALSE(content.trajectory->body_is_flu);
  }
  const FileContent named = Inspect(Poses(
      [](double w, double x, double y, double z) {
        return Row{x, y, z, w};
      },
      "# timestamp latitude longitude height qx qy qz qw\n"));
  EXPECT_THAT(named.columns, ElementsAre("t", "lat", "lon", "h", "qx", "qy", "qz", "qw"));
  const FileContent exchanged = Inspect(Poses(
      [](double w, double x, double y, double z) {
        return Row{w, x, y, z};
      },
      "", true));
  EXPECT_THAT(exchanged.columns, ElementsAre("t", "lon", "lat", "h", "qw", "qx", "qy", "qz"));
}

TEST(ContentColumns, LogsAreKnownByTheirSentences) {
  const std::string gga = "$GNGGA,094942.00,4630.0,N,00630.0,E,4,12,0.8,450.0,M,50.0,M,1.0,0001\n";
  EXPECT_EQ(Inspect(gga).gnss_format, GnssFormat::kNmea);
  EXPECT_EQ(Inspect("receiver ready\r\n$GPTXT,01,01,02,hello\r\n" + gga).gnss_format,
            GnssFormat::kNmea);
  const FileContent inertial = Inspect("$VNIMU,-02.1,+00.4,+01.3,-00.1,+00.02,-09.81*5F\r\n");
  EXPECT_EQ(inertial.kind, FileKind::kUnknown);
  EXPECT_THAT(inertial.why, AllOf(HasSubstr("sentences of type VNIMU"), HasSubstr("CSV")));
  const FileContent status = Inspect("$POS,2280,381000.000,1,4368857.1,499277.1,4609853.1\n");
  EXPECT_THAT(status.why, HasSubstr("status file of RTKLIB"));
  const std::string row = "46.5 6.5 500.0 1 12 0.015 0.015 0.03 0.0 0.0 0.0 0.00 25.0\n";
  EXPECT_EQ(Inspect("2023/09/21 09:50:00.000 " + row).gnss_format, GnssFormat::kRtklib);
  EXPECT_EQ(Inspect("2280 381000.000 " + row).gnss_format, GnssFormat::kRtklib);
  EXPECT_EQ(Inspect("\xEF\xBB\xBF%  GPST  latitude(deg) longitude(deg)\n").gnss_format,
            GnssFormat::kRtklib);
  EXPECT_THAT(Inspect(std::string("1\0,\0\x32\0,\0\x33\0\n\0", 12)).why, HasSubstr("UTF-16"));
}

TEST(ContentColumns, AnUnknownTextSaysWhatIsNearest) {
  const FileContent content = Inspect(Positions([](double t, double lat, double lon, double h) {
    return Row{t, lat, 1e3 * lon, h};
  }));
  EXPECT_EQ(content.kind, FileKind::kUnknown);
  EXPECT_THAT(content.why, AllOf(HasSubstr("; nearest to "), HasSubstr("; then to ")));
}

}  // namespace dn::files_test
