// Files of GNSS positions as receivers and programs write them.
#include <dn/files/file_content.h>
#include <dn/geo/local_frame.h>
#include <dn/gnss/gnss_data.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "testing/temp_folder.h"

namespace dn::files_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

FileContent LookAt(const std::string& text, const std::string& name = "positions.csv") {
  const testing::TempFolder folder;
  folder.Write(name, text);
  return InspectFile(folder.path() / name);
}

/// A position of a flight to the north-east at 1 Hz.
struct Place {
  double t_s, lat_deg, lon_deg, h_m;
};

std::string FlightRows(const std::function<std::string(const Place&)>& format) {
  std::string text;
  for (int i = 0; i < 120; ++i) {
    const double turn = 0.0006 * std::sin(0.05 * i);
    const Place place{381000.0 + i, 46.5012345 + 0.00041 * i, 6.5023456 + turn, 500 + 0.1 * i};
    text += format(place) + "\n";
  }
  return text;
}

std::string AfterQuality(const Place& p) {
  return fmt::format("{:.3f},4,12,{:.9f},{:.9f},{:.4f}", p.t_s, p.lat_deg, p.lon_deg, p.h_m);
}

TEST(ContentGnss, QualityBeforeThePosition) {
  const std::string rows = FlightRows(AfterQuality);
  for (const char* header : {"t,fix,nsat,gpsLatitude,gpsLongitude,gpsHeight\n",
                             "t,fix,nsat,LatitudeDegrees,LongitudeDegrees,AltitudeMeters\n",
                             "t,fix,nsat,latDeg,lonDeg,hEllM\n", "t,fix,nsat,phi,lambda,h\n",
                             "t,fix,nsat,B,L,H\n", "t,fix,nsat,latdeg,londeg,height\n",
                             "towSec,fixType,numSats,positionLat,positionLon,positionHeight\n",
                             "gpsTime,fixType,numSats,gpsLat,gpsLon,gpsHeight\n", ""}) {
    SCOPED_TRACE(header);
    const FileContent content = LookAt(header + rows);
    EXPECT_EQ(content.kind, FileKind::kGnss) << content.why;
    EXPECT_THAT(content.columns, ElementsAre("t", "skip", "skip", "lat", "lon", "h"));
    EXPECT_FALSE(content.has_sigma);
  }
  const FileContent dilution = LookAt(FlightRows([](const Place& p) {
    return fmt::format("{:.3f} 0.8 {:.9f} {:.9f} {:.4f}", p.t_s, p.lat_deg, p.lon_deg, p.h_m);
  }));
  EXPECT_THAT(dilution.columns, ElementsAre("t", "skip", "lat", "lon", "h"));
  const FileContent counts = LookAt(
      FlightRows([](const Place& p) { return fmt::format("{:.3f} 4 12 {:.4f}", p.t_s, p.h_m); }));
  EXPECT_EQ(counts.kind, FileKind::kUnknown);
}

// A magnetometer after the rates moves like latitude, longitude and height.
TEST(ContentGnss, OtherKindsComeBeforeAPositionElsewhere) {
  std::string text =
      "SampleTimeFine,Euler_X,Euler_Y,Euler_Z,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,"
      "Mag_X,Mag_Y,Mag_Z\n";
  for (int i = 0; i < 1000; ++i) {
    const double s = std::sin(0.7 * i), c = std::cos(0.31 * i), slow = 1e-5 * std::sin(0.01 * i);
    text += fmt::format(
        "{},1.2,2.3,{:.3f},{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f},{:.8f},{:.8f},-1.0\n",
        677583000 + 8333 * i, 40 * s, 0.3 * s, 0.2 * c, 9.8 + 0.2 * s, 0.2 * s, 0.3 * c,
        0.1 * s * c, -0.4345703 + slow, -0.4877929 - slow);
  }
  const FileContent content = LookAt(text);
  EXPECT_EQ(content.kind, FileKind::kImu) << content.why;
  const FileContent drone =
      LookAt("time,lat,lon,ground_elevation(m),altitude(m)\n" + FlightRows([](const Place& p) {
               return fmt::format("{:.3f},{:.9f},{:.9f},unknown,{:.3f}", p.t_s, p.lat_deg,
                                  p.lon_deg, p.h_m);
             }));
  EXPECT_EQ(drone.kind, FileKind::kGnss) << drone.why;
  EXPECT_THAT(drone.columns, ElementsAre("t", "lat", "lon", "skip", "h"));
}

TEST(ContentGnss, HemispheresAreRead) {
  const testing::TempFolder folder;
  for (const char* header : {"t,lat,NS,lon,EW,h\n", "t,lat,n/s,lon,e/w,h\n",
                             "t,Latitude,Lat Dir,Longitude,Lon Dir,Height\n", ""}) {
    SCOPED_TRACE(header);
    folder.Write("g.csv", header + FlightRows([](const Place& p) {
                            return fmt::format("{:.3f},{:.9f},S,{:.9f},w,{:.3f}", p.t_s, p.lat_deg,
                                               p.lon_deg, p.h_m);
                          }));
    const FileContent content = InspectFile(folder.path() / "g.csv");
    ASSERT_EQ(content.kind, FileKind::kGnss) << content.why;
    ASSERT_THAT(content.columns, ElementsAre("t", "lat", "lat_ns", "lon", "lon_ew", "h"));
    GnssColumns columns;
    columns.names = content.columns;
    const GnssData data = ReadGnss(folder.path() / "g.csv", GnssFormat::kOdyn, 0.0, columns);
    EXPECT_NEAR(data.epochs.front().antenna.lat_rad * kDegPerRad, -46.5012345, 1e-12);
    EXPECT_NEAR(data.epochs.front().antenna.lon_rad * kDegPerRad, -6.5023456, 1e-12);
  }
}

TEST(ContentGnss, AccuraciesBecomeSigmas) {
  const std::string rows = FlightRows([](const Place& p) {
    return fmt::format("{:.3f},{:.9f},{:.9f},{:.4f},0.02,0.03", p.t_s, p.lat_deg, p.lon_deg, p.h_m);
  });
  for (const char* names :
       {"Horizontal Accuracy (m),Vertical Accuracy (m)", "horizontalAccuracy,verticalAccuracy",
        "SDHoriz,SDHeight", "eph,epv", "hAcc,vAcc", "horizontal_std,vertical_std"}) {
    SCOPED_TRACE(names);
    const FileContent content = LookAt("time,lat,lon,height," + std::string(names) + "\n" + rows);
    EXPECT_EQ(content.kind, FileKind::kGnss) << content.why;
    EXPECT_THAT(content.columns, ElementsAre("t", "lat", "lon", "h", "sigma_en", "sigma_u"));
    EXPECT_TRUE(content.has_sigma);
  }
  for (const char* names : {"accuracy (m),speed", "accuracy,satellites", "hAcc,pdop"}) {
    SCOPED_TRACE(names);
    const FileContent content = LookAt("time,lat,lon,height," + std::string(names) + "\n" + rows);
    EXPECT_FALSE(content.has_sigma);
    EXPECT_THAT(content.accuracy, HasSubstr("cc"));
  }
}

TEST(ContentGnss, UnknownAccuraciesAreLeftOut) {
  for (const char* rest : {"-1,3", "nan,3", "4,-1"}) {
    SCOPED_TRACE(rest);
    const FileContent content = LookAt("time,lat,lon,height,horizontalAccuracy,verticalAccuracy\n" +
                                       FlightRows([&](const Place& p) {
                                         return fmt::format("{:.3f},{:.9f},{:.9f},{:.4f},{}", p.t_s,
                                                            p.lat_deg, p.lon_deg, p.h_m, rest);
                                       }));
    EXPECT_EQ(content.kind, FileKind::kGnss) << content.why;
    EXPECT_FALSE(content.has_sigma);
    EXPECT_EQ(content.accuracy, "'horizontalAccuracy'");
  }
}

TEST(ContentGnss, VariancesAndCovariancesBecomeSigmas) {
  const FileContent variances =
      LookAt("t,lat,lon,h,var_e,var_n,var_u\n" + FlightRows([](const Place& p) {
               return fmt::format("{:.3f},{:.9f},{:.9f},{:.4f},0.0004,0.0004,0.0009", p.t_s,
                                  p.lat_deg, p.lon_deg, p.h_m);
             }));
  EXPECT_THAT(variances.columns, ElementsAre("t", "lat", "lon", "h", "var_e", "var_n", "var_u"));
  EXPECT_TRUE(variances.has_sigma);
  for (const char* pattern :
       {"field.position_covariance{}", "position_covariance_{}", "position_covariance[{}]"}) {
    SCOPED_TRACE(pattern);
    std::string header = "t,lat,lon,h";
    for (int k = 0; k < 9; ++k) header += "," + fmt::format(fmt::runtime(pattern), k);
    const FileContent content =
        LookAt(header + "\n" + FlightRows([](const Place& p) {
                 return fmt::format("{:.3f},{:.9f},{:.9f},{:.4f},4e-4,0,0,0,4e-4,0,0,0,9e-4", p.t_s,
                                    p.lat_deg, p.lon_deg, p.h_m);
               }));
    EXPECT_THAT(content.columns, ElementsAre("t", "lat", "lon", "h", "var_e", "skip", "skip",
                                             "skip", "var_n", "skip", "skip", "skip", "var_u"));
  }
}

TEST(ContentGnss, OtherColumnsAreNoSigmas) {
  for (const char* rest : {"4,12,0.8", "30.1,90.0,0.2", "1,14,25", "12,0.8,1.1"}) {
    SCOPED_TRACE(rest);
    const FileContent content = LookAt(FlightRows([&](const Place& p) {
      return fmt::format("{:.3f},{:.9f},{:.9f},{:.4f},{}", p.t_s, p.lat_deg, p.lon_deg, p.h_m,
                         rest);
    }));
    EXPECT_EQ(content.kind, FileKind::kGnss) << content.why;
    EXPECT_THAT(content.columns, ElementsAre("t", "lat", "lon", "h"));
    EXPECT_FALSE(content.has_sigma);
    EXPECT_THAT(content.why, HasSubstr("columns 5-7 are not used"));
  }
  const FileContent dilutions = LookAt(FlightRows([](const Place& p) {
    return fmt::format("{:.3f},{:.9f},{:.9f},{:.4f},0.8,1.2,1.5", p.t_s, p.lat_deg, p.lon_deg,
                       p.h_m);
  }));
  EXPECT_THAT(dilutions.why, HasSubstr("dilutions of precision"));
}

TEST(ContentGnss, AnglesInAnUnknownOrderAreNoPositionsOfGnss) {
  const FileContent content = LookAt(FlightRows([](const Place& p) {
    return fmt::format("{:.3f},{:.9f},{:.9f},{:.4f},{:.3f},{:.3f},{:.3f}", p.t_s, p.lat_deg,
                       p.lon_deg, p.h_m, 90 + std::sin(p.t_s), 2 * std::sin(p.t_s), 200.0);
  }));
  EXPECT_EQ(content.kind, FileKind::kUnknown);
  EXPECT_THAT(content.why, HasSubstr("not sigmas"));
}

TEST(ContentGnss, UnitsInNames) {
  const auto rows = [](double height_factor, const char* rest = "") {
    return FlightRows([=](const Place& p) {
      return fmt::format("{:.3f},{:.9f},{:.9f},{:.4f}{}", p.t_s, p.lat_deg, p.lon_deg,
                         height_factor * p.h_m, rest);
    });
  };
  EXPECT_THAT(LookAt("t,lat,lon,height (ft)\n" + rows(3.28084)).columns,
              ElementsAre("t", "lat", "lon", "h_ft"));
  EXPECT_THAT(
      LookAt("t,lat,lon,height_mm,sde(mm),sdn(mm),sdu(mm)\n" + rows(1e3, ",15,15,30")).columns,
      ElementsAre("t", "lat", "lon", "h_mm", "sigma_e_mm", "sigma_n_mm", "sigma_u_mm"));
  EXPECT_THAT(LookAt("t,lat,lon,heightCm\n" + rows(1e2)).columns,
              ElementsAre("t", "lat", "lon", "h_cm"));
  EXPECT_THAT(LookAt("t,lat,lon,h\n" + rows(1e3)).why, HasSubstr("too large for metres"));
  EXPECT_THAT(LookAt("t,lat_rad,lonRad,h\n" + FlightRows([](const Place& p) {
                       return fmt::format("{:.3f},{:.9f},{:.9f},{:.4f}", p.t_s,
                                          p.lat_deg / kDegPerRad, p.lon_deg / kDegPerRad, p.h_m);
                     }))
                  .columns,
              ElementsAre("t", "lat_rad", "lon_rad", "h"));
}

TEST(ContentGnss, AnglesAsIntegersAndWithMinutes) {
  const auto minutes = [](double deg) {
    return 100.0 * std::floor(deg) + 60.0 * (deg - std::floor(deg));
  };
  const FileContent ddmm =
      LookAt("t,lat,lon,h\n" + FlightRows([&](const Place& p) {
               return fmt::format("{:.3f},{:.7f},{:.7f},{:.4f}", p.t_s, minutes(p.lat_deg),
                                  minutes(p.lon_deg), p.h_m);
             }));
  EXPECT_EQ(ddmm.kind, FileKind::kGnss) << ddmm.why;
  EXPECT_THAT(ddmm.columns, ElementsAre("t", "lat_ddmm", "lon_ddmm", "h"));
  EXPECT_THAT(ddmm.why, HasSubstr("degrees and minutes"));
  const FileContent integers =
      LookAt("t,lat,lon,alt\n" + FlightRows([](const Place& p) {
               return fmt::format("{:.3f},{:.0f},{:.0f},{:.0f}", p.t_s, 1e7 * p.lat_deg,
                                  1e7 * p.lon_deg, 1e3 * p.h_m);
             }));
  EXPECT_EQ(integers.kind, FileKind::kGnss) << integers.why;
  EXPECT_THAT(integers.columns, ElementsAre("t", "lat_1e7", "lon_1e7", "h_mm"));
  const FileContent unsure = LookAt("t,lat,lon,alt\n" + FlightRows([](const Place& p) {
                                      return fmt::format("{:.3f},{:.0f},{:.0f},{:.0f}", p.t_s,
                                                         1e7 * p.lat_deg, 1e7 * p.lon_deg, p.h_m);
                                    }));
  EXPECT_EQ(unsure.kind, FileKind::kUnknown);
  EXPECT_THAT(unsure.why, HasSubstr("may be in m, cm or mm"));
}

TEST(ContentGnss, CalendarTimes) {
  for (const char* format : {"2023-09-21T09:{:02}:{:02}.000Z", "2023-09-21 09:{:02}:{:02}",
                             "2023/09/21 11:{:02}:{:02}+02:00"}) {
    SCOPED_TRACE(format);
    const FileContent content =
        LookAt("time,lat,lon,h\n" + FlightRows([&](const Place& p) {
                 const int i = static_cast<int>(p.t_s) - 381000;
                 return fmt::format(fmt::runtime(format), i / 60, i % 60) +
                        fmt::format(",{:.9f},{:.9f},{:.4f}", p.lat_deg, p.lon_deg, p.h_m);
               }));
    EXPECT_EQ(content.kind, FileKind::kGnss) << content.why;
    EXPECT_THAT(content.columns, ElementsAre("t_utc", "lat", "lon", "h"));
    EXPECT_EQ(content.time_offset_s, 2280 * 604800.0);
  }
  const FileContent still = LookAt(
      "Date,Time,Latitude,Longitude,Height\n" + FlightRows([](const Place& p) {
        return fmt::format("21/09/2023,09:49:42,{:.9f},{:.9f},{:.4f}", p.lat_deg, p.lon_deg, p.h_m);
      }));
  EXPECT_EQ(still.kind, FileKind::kUnknown);
  EXPECT_THAT(still.why, HasSubstr("no time that increases"));
}

TEST(ContentGnss, GeocentricAndGridCoordinates) {
  const FileContent ecef =
      LookAt("t,fix,X,Y,Z\n" + FlightRows([](const Place& p) {
               const double s = p.t_s - 381000.0;
               return fmt::format("{:.3f},4,{:.4f},{:.4f},{:.4f}", p.t_s, 4364034.0 - 5 * s,
                                  498996.0 + 26 * s, 4609960.0 - s);
             }));
  EXPECT_EQ(ecef.kind, FileKind::kGnss) << ecef.why;
  EXPECT_EQ(ecef.crs, "ecef");
  EXPECT_THAT(ecef.columns, ElementsAre("t", "skip", "x", "y", "z"));
  const FileContent grid =
      LookAt("t,fix,Easting,Northing,Height\n" + FlightRows([](const Place& p) {
               const double s = p.t_s - 381000.0;
               return fmt::format("{:.3f},4,{:.3f},{:.3f},{:.3f}", p.t_s, 310206.0 + 26 * s,
                                  5161038.0 + s, p.h_m);
             }));
  EXPECT_EQ(grid.kind, FileKind::kUnknown);
  EXPECT_THAT(grid.why, AllOf(HasSubstr("[t, skip, east, north, h]"), HasSubstr("utm:32n")));
}

TEST(ContentGnss, SecondsBeforeTheWeekAreNoPairs) {
  const FileContent content = LookAt(FlightRows([](const Place& p) {
    return fmt::format("{:.3f} 2280 {:.9f} {:.9f} {:.4f} 1 14 0 0 0", p.t_s, p.lat_deg, p.lon_deg,
                       p.h_m);
  }));
  EXPECT_EQ(content.kind, FileKind::kGnss) << content.why;
  EXPECT_THAT(content.columns, ElementsAre("t", "week", "lat", "lon", "h"));
}

TEST(ContentGnss, AHeightAboveTheSeaIsNamed) {
  const FileContent content = LookAt(
      "GPSTime Latitude Longitude H-MSL Roll Pitch Heading\n" + FlightRows([](const Place& p) {
        return fmt::format("{:.3f} {:.9f} {:.9f} {:.3f} {:.4f} {:.4f} {:.4f}", p.t_s, p.lat_deg,
                           p.lon_deg, p.h_m, std::sin(p.t_s), std::cos(p.t_s),
                           3.0 + std::sin(0.3 * p.t_s));
      }));
  EXPECT_EQ(content.kind, FileKind::kUnknown);
  EXPECT_THAT(content.why, HasSubstr("'H-MSL' is above the sea"));
}

TEST(ContentGnss, FilesOfOtherFormatsAreNamed) {
  const std::string blanks(20, ' ');
  for (const auto& [text, reason] : std::vector<std::pair<std::string, std::string>>{
           {"<?xml version=\"1.0\"?>\n<gpx version=\"1.1\">\n", "GPX"},
           {"<?xml version=\"1.0\"?><kml></kml>\n", "KML"},
           {"     3.04" + blanks + "OBSERVATION DATA    M     RINEX VERSION / TYPE\n", "RINEX"},
           {"ply\nformat ascii 1.0\n", "PLY"},
           {"1\t381000.0\t[2280]\t1,N\t2,E\t3,V\t46.5,Lat\t6.5,Lon\t635.9,Ellh\t0.01, 0.01, 0.03\n",
            ".MRK"},
           {"PK\x03\x04 archive", "ZIP"},
           {"#ROSBAG V2.0\n", "ROS"},
           {"#BESTXYZA,COM1,0,55.0,FINE,2280,381000.0,0,d8,16;SOL_COMPUTED,NARROW_INT,1,2,3*00\n",
            "log BESTGNSSPOS"},
           {"%CORRIMUDATASA,2280,381000.02;2280,381000.02,0,0,0,0,0,0*f4\n", "log RAWIMUX"},
           {"t;a;b;c\n381000,02;0,5;0,6;0,7\n", "decimal points"}}) {
    SCOPED_TRACE(reason);
    const FileContent content = LookAt(text);
    EXPECT_EQ(content.kind, FileKind::kUnknown);
    EXPECT_THAT(content.why, HasSubstr(reason));
  }
}

TEST(ContentGnss, RecordsWhoseTimesDoNotIncreaseAreNoTrajectory) {
  std::string bytes;
  for (int i = 0; i < 40; ++i) {
    const double value = 1.0 + i % 2;
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  EXPECT_EQ(LookAt(bytes, "events.out").kind, FileKind::kUnknown);
}

TEST(ContentGnss, SentencesAfterTheTimeOfALogger) {
  EXPECT_EQ(LookAt("2023-09-21 09:49:42.123 $GNGGA,094942.00,4634.5654661,N,00631.3819144,E,4,12,"
                   "0.8,585.9219,M,50.000,M,1.0,0001*6E\n")
                .gnss_format,
            GnssFormat::kNmea);
}

// Flight controllers write attitudes that do not follow the course.
TEST(ContentGnss, AttitudesOfAFlightControllerAreFound) {
  const auto rows = [](double unit_deg) {
    return FlightRows([=](const Place& p) {
      const double slow = 0.1 * p.t_s;
      return fmt::format("{:.3f},{:.9f},{:.9f},{:.4f},{:.5f},{:.5f},{:.5f}", p.t_s,
                         93.0 - p.lat_deg, p.lon_deg, p.h_m,
                         (100.0 + 20.0 * std::sin(slow)) * unit_deg,
                         4.0 * std::cos(slow) * unit_deg, 3.0 * std::sin(2.0 * slow) * unit_deg);
    });
  };
  const char* begin = "time,latitude,longitude,altitude(meters),";
  for (const char* header :
       {"compass_heading(degrees),pitch(degrees),roll(degrees)\n", "OSD.yaw,OSD.pitch,OSD.roll\n",
        "Yaw [deg],Pitch [deg],Roll [deg]\n"}) {
    SCOPED_TRACE(header);
    const FileContent content = LookAt(begin + (header + rows(1.0)));
    EXPECT_EQ(content.kind, FileKind::kGnss) << content.why;
    EXPECT_THAT(content.attitude, ElementsAre("t", "lat", "lon", "h", "heading", "pitch", "roll"));
  }
  for (const char* header : {"yaw,pitch,roll\n", "heading(rad),pitch(rad),roll(rad)\n"}) {
    SCOPED_TRACE(header);
    const FileContent content = LookAt(begin + (header + rows(kRadPerDeg)));
    EXPECT_THAT(content.attitude,
                ElementsAre("t", "lat", "lon", "h", "heading_rad", "pitch_rad", "roll_rad"));
  }
  for (const char* header : {"gimbal_heading,gimbal_pitch,gimbal_roll\n", "a,b,c\n"}) {
    SCOPED_TRACE(header);
    EXPECT_THAT(LookAt(begin + (header + rows(1.0))).attitude, IsEmpty());
  }
}

/// Formats the date and the time of day of a place.
std::string CalendarRow(const Place& p, const char* date, const char* time_format, char separator) {
  const double day_s = std::fmod(p.t_s - 18.0, 86400.0);
  const int whole = static_cast<int>(day_s);
  const std::string time = fmt::format(fmt::runtime(time_format), whole / 3600, whole / 60 % 60,
                                       whole % 60 + day_s - whole);
  return fmt::format("{0}{4}{1}{4}{2:.9f}{4}{3:.9f}{4}{5:.4f}", date, time, p.lat_deg, p.lon_deg,
                     separator, p.h_m);
}

TEST(ContentGnss, ADateAndTheTimeOfDayInTwoColumns) {
  struct Case {
    const char *header, *date, *time_format, *column;
    char separator;
  };
  constexpr const char* kColons = "{:02}:{:02}:{:06.3f}";
  constexpr const char* kPlain = "{:02}{:02}{:05.2f}";
  for (const Case& each :
       {Case{"Date,Time,Latitude,Longitude,Altitude\n", "21/09/2023", kColons, "date_utc_dmy", ','},
        Case{"date,time,lat,lon,h\n", "2023-09-21", kColons, "date_utc", ','},
        Case{"Date;UTC Time;Lat;Lon;Height(m)\n", "09/21/2023", kColons, "date_utc_mdy", ';'},
        Case{"", "2023/09/21", kColons, "date_utc", ' '},
        Case{"Datum;Zeit;Breite;lon;h\n", "21.09.2023", kColons, "date_utc", ';'},
        Case{"date,time,lat,lon,alt\n", "20230921", kPlain, "date_utc", ','},
        Case{"UTC date,UTC time,lat,lon,alt\n", "210923", kPlain, "date_utc_dmy", ','}}) {
    SCOPED_TRACE(each.date);
    const testing::TempFolder folder;
    const std::string rows = FlightRows([&](const Place& p) {
      return CalendarRow(p, each.date, each.time_format, each.separator);
    });
    folder.Write("g.csv", each.header + rows);
    const FileContent content = InspectFile(folder.path() / "g.csv");
    ASSERT_EQ(content.kind, FileKind::kGnss) << content.why;
    EXPECT_THAT(content.columns, ElementsAre(each.column, "time_of_day", "lat", "lon", "h"));
    GnssColumns columns;
    columns.names = content.columns;
    const GnssData data =
        ReadGnss(content.file, content.gnss_format, content.time_offset_s, columns);
    EXPECT_NEAR(data.epochs.front().t_s, 381000.0, 1e-6);
    EXPECT_NEAR(data.epochs.back().t_s, 381119.0, 1e-6);
  }
}

TEST(ContentGnss, SecondsOfGpsTimeComeBeforeADate) {
  const FileContent content =
      LookAt("UTCDate,UTCTime,Latitude,Longitude,H-Ell,GPSTime\n" + FlightRows([](const Place& p) {
               return CalendarRow(p, "9/21/2023", "{:02}:{:02}:{:05.2f}", ',') +
                      fmt::format(",{:.2f}", p.t_s);
             }));
  EXPECT_THAT(content.columns, ElementsAre("skip", "skip", "lat", "lon", "h", "t"));
  EXPECT_EQ(content.time_offset_s, 0.0);
}

TEST(ContentGnss, ADateMayBeInGpsTime) {
  for (const char* header : {"GPSDate,GPSTime,lat,lon,h\n", "date,GPS time,lat,lon,h\n",
                             "UTC date,GPS time,lat,lon,h\n"}) {
    SCOPED_TRACE(header);
    const FileContent content =
        LookAt(header + FlightRows([](const Place& p) {
                 return CalendarRow(p, "20230921", "{:02}{:02}{:05.2f}", ',');
               }));
    const bool utc = std::string(header).starts_with("UTC");
    EXPECT_THAT(content.columns,
                ElementsAre(utc ? "date_utc" : "date_gps", "time_of_day", "lat", "lon", "h"));
    EXPECT_EQ(content.time_offset_s, 2280 * 604800.0);
  }
}

TEST(ContentGnss, AnAmbiguousDateIsNamed) {
  const auto look = [](const char* date) {
    return LookAt("date,time,lat,lon,h\n" + FlightRows([&](const Place& p) {
                    return CalendarRow(p, date, "{:02}:{:02}:{:06.3f}", ',');
                  }));
  };
  EXPECT_THAT(look("03/04/2024").why, HasSubstr("'03/04/2024' is read with the day first"));
  EXPECT_THAT(look("04/04/2024").why, Not(HasSubstr("day first")));
  EXPECT_THAT(look("13/04/2024").why, Not(HasSubstr("day first")));
}

}  // namespace dn::files_test
