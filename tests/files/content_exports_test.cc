// Headers of exports by other programs: post-processing, robots, data loggers.
#include <dn/files/file_content.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "testing/temp_folder.h"

namespace dn::files_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

FileContent InspectText(const std::string& text) {
  const testing::TempFolder folder;
  folder.Write("export.txt", text);
  return InspectFile(folder.path() / "export.txt");
}

/// A pose on a winding course, level and facing along it.
struct CoursePose {
  double t_s, lat_deg, lon_deg, east_m, north_m, h_m, heading_deg;
};

std::string Rows(const std::function<std::string(const CoursePose&)>& format) {
  std::string text;
  double east_m = 0.0, north_m = 0.0;
  for (int i = 0; i < 600; ++i) {
    const double heading = 0.7 + 1.5 * std::sin(0.01 * i);
    north_m += 6.0 * std::cos(heading);
    east_m += 6.0 * std::sin(heading);
    text += format({381000 + 0.1 * i, 46.5 + north_m / 111000.0, 6.5 + east_m / 76000.0,
                    320000.0 + east_m, 5150000.0 + north_m, 600.0,
                    heading * 180.0 / std::numbers::pi}) +
            "\n";
  }
  return text;
}

std::string DegreesMinutesSeconds(double deg) {
  const double minutes = 60.0 * (deg - std::floor(deg));
  return fmt::format("{:4.0f} {:02.0f} {:011.8f}", std::floor(deg), std::floor(minutes),
                     60.0 * (minutes - std::floor(minutes)));
}

TEST(ContentExports, InertialExplorer) {
  const std::string head =
      "Project:     flight7\n"
      "Program:     Inertial Explorer Version 8.80\n"
      "Datum:       WGS84, (processing datum)\n\n";
  const std::string names =
      "        Week      GPSTime       Latitude      Longitude        H-Ell        SDNorth"
      "       SDEast     SDHeight         Roll        Pitch      Heading\n";
  const auto row = [](const CoursePose& p) {
    return fmt::format("2280 {:.3f} {:.10f} {:.10f} {:.4f} 0.02 0.02 0.03 0.1 0.2 {:.8f}", p.t_s,
                       p.lat_deg, p.lon_deg, p.h_m, p.heading_deg);
  };
  const FileContent content = InspectText(
      head + names +
      "     (weeks)  (sec)  (deg)  (deg)  (m)  (m)  (m)  (m)  (deg)  (deg)  (deg)\n" + Rows(row));
  EXPECT_EQ(content.kind, FileKind::kTrajectory) << content.why;
  EXPECT_THAT(content.columns, ElementsAre("week", "t", "lat", "lon", "h", "skip", "skip", "skip",
                                           "roll", "pitch", "heading"));
  EXPECT_EQ(content.trajectory->attitude, TrajectoryColumns::Attitude::kRollPitchHeading);
}

TEST(ContentExports, DegreesMinutesSeconds) {
  const std::string names =
      "   GPSTime     Latitude    Longitude    H-Ell    Roll   Pitch   Heading\n"
      "     (sec)   (+/-D M S)   (+/-D M S)      (m)   (deg)   (deg)     (deg)\n";
  const FileContent content =
      InspectText(names + Rows([](const CoursePose& p) {
                    return fmt::format("{:.3f} {} {} {:.4f} 0.1 0.2 {:.8f}", p.t_s,
                                       DegreesMinutesSeconds(p.lat_deg),
                                       DegreesMinutesSeconds(p.lon_deg), p.h_m, p.heading_deg);
                  }));
  EXPECT_EQ(content.kind, FileKind::kTrajectory) << content.why;
  EXPECT_THAT(content.columns, ElementsAre("t", "lat", "lat_min", "lat_sec", "lon", "lon_min",
                                           "lon_sec", "h", "roll", "pitch", "heading"));
}

TEST(ContentExports, PosPac) {
  const std::string names =
      "TIME  DISTANCE  EASTING  NORTHING  ELLIPSOID HEIGHT  LATITUDE  LONGITUDE  ELLIPSOID HEIGHT"
      "  ROLL  PITCH  HEADING  EAST VELOCITY  NORTH VELOCITY  UP VELOCITY  EAST SD  NORTH SD"
      "  HEIGHT SD  ROLL SD  PITCH SD  HEADING SD\n";
  const auto row = [](const CoursePose& p) {
    return fmt::format(
        "{:.3f} 10 {:.3f} {:.3f} 600 {:.9f} {:.9f} {:.3f} 0.1 0.2 {:.5f} 1 2 0 0.01 0.01 0.02 "
        "0.002 0.002 0.005",
        p.t_s, p.east_m, p.north_m, p.lat_deg, p.lon_deg, p.h_m, p.heading_deg);
  };
  const FileContent content =
      InspectText("POSPac export\n\n" + names + "(time in Sec, distance in Meters)\n" + Rows(row));
  EXPECT_EQ(content.kind, FileKind::kTrajectory) << content.why;
  EXPECT_THAT(content.columns, ElementsAre("t", "skip", "skip", "skip", "h", "lat", "lon", "skip",
                                           "roll", "pitch", "heading"));
  // Without geographic coordinates, those of the grid.
  const FileContent grid = InspectText(
      "TIME (s), EASTING (m), NORTHING (m), ELLIPSOID HEIGHT (m), ROLL (rad), PITCH "
      "(rad), HEADING (rad)\n" +
      Rows([](const CoursePose& p) {
        return fmt::format("{:.3f},{:.3f},{:.3f},{:.3f},0.001,0.002,{:.6f}", p.t_s, p.east_m,
                           p.north_m, p.h_m, p.heading_deg / 180.0 * std::numbers::pi);
      }));
  EXPECT_EQ(grid.kind, FileKind::kTrajectory) << grid.why;
  EXPECT_THAT(grid.columns,
              ElementsAre("t", "east", "north", "h", "roll_rad", "pitch_rad", "heading_rad"));
  EXPECT_EQ(grid.trajectory->crs, "utm:");
}

TEST(ContentExports, AnglesInRadiansWithoutAUnit) {
  const auto row = [](const CoursePose& p) {
    return fmt::format("{:.3f} {:.9f} {:.9f} {:.3f} 0.001 0.002 {:.6f}", p.t_s, p.lat_deg,
                       p.lon_deg, p.h_m, p.heading_deg / 180.0 * std::numbers::pi);
  };
  for (const char* header : {"", "time lat lon height roll pitch yaw\n"}) {
    SCOPED_TRACE(header);
    const FileContent content = InspectText(header + Rows(row));
    EXPECT_EQ(content.kind, FileKind::kTrajectory) << content.why;
    EXPECT_THAT(content.columns,
                ElementsAre("t", "lat", "lon", "h", "roll_rad", "pitch_rad", "heading_rad"));
    EXPECT_THAT(content.why, HasSubstr("in rad"));
  }
}

/// Returns the quaternion x y z w from forward-left-up to east-north-up.
std::string EnuQuaternion(const CoursePose& p, const char* separator = " ") {
  const double yaw = (90.0 - p.heading_deg) / 180.0 * std::numbers::pi;
  return fmt::format("0{0}0{0}{1:.9f}{0}{2:.9f}", separator, std::sin(yaw / 2.0),
                     std::cos(yaw / 2.0));
}

TEST(ContentExports, TumHeaders) {
  for (const char* header :
       {"# timestamp tx ty tz qx qy qz qw\n", "#timestamp x y z q_x q_y q_z q_w\n",
        "% time pos_x pos_y pos_z qx qy qz qw\n",
        "t,position.x,position.y,position.z,orientation.x,orientation.y,orientation.z,"
        "orientation.w\n",
        "# stamp px py pz quat_x quat_y quat_z quat_w\n"}) {
    SCOPED_TRACE(header);
    const FileContent content = InspectText(
        header + Rows([](const CoursePose& p) {
          return fmt::format("{:.3f} {:.3f} {:.3f} {:.3f} {}", p.t_s, p.east_m - 320000.0,
                             p.north_m - 5150000.0, p.h_m, EnuQuaternion(p));
        }));
    EXPECT_EQ(content.kind, FileKind::kTrajectory) << content.why;
    EXPECT_THAT(content.columns, ElementsAre("t", "x", "y", "z", "qx", "qy", "qz", "qw"));
    EXPECT_EQ(content.trajectory->crs, "map");
    EXPECT_EQ(content.trajectory->attitude, TrajectoryColumns::Attitude::kQuaternionEnu);
    EXPECT_TRUE(content.trajectory->body_is_flu);
  }
}

/// Returns nanoseconds since 1970.
long long Stamp(const CoursePose& p) {
  return 1694908782000000000LL + std::llround(1e3 * p.t_s) * 1000000LL;
}

TEST(ContentExports, RobotLogs) {
  const auto imu = [](const std::string& head, bool seconds_apart) {
    std::string text = head;
    for (int i = 0; i < 2000; ++i) {
      const double t = 0.02 * i, s = std::sin(0.7 * t), shake = std::sin(11.3 * i);
      const long long stamp = 1694908782000000000LL + 381000000000000LL + 20000000LL * i;
      const std::string time =
          seconds_apart ? fmt::format("{}.25,{},{},{},imu_link", stamp / 1000000000, i,
                                      stamp / 1000000000, stamp % 1000000000)
                        : fmt::format("{},{},{},imu_link", stamp + 300000 * (i % 3), i, stamp);
      text += time + fmt::format(",0,0,0,1,{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f}\n",
                                 0.1 * s + 0.02 * shake, 0.05 * s, 0.02 * shake, 0.3 * shake,
                                 0.8 * s, 9.81 + 0.4 * s);
    }
    return InspectText(text);
  };
  const FileContent topic =
      imu("%time,field.header.seq,field.header.stamp,field.header.frame_id,field.orientation.x,"
          "field.orientation.y,field.orientation.z,field.orientation.w,field.angular_velocity.x,"
          "field.angular_velocity.y,field.angular_velocity.z,field.linear_acceleration.x,"
          "field.linear_acceleration.y,field.linear_acceleration.z\n",
          false);
  EXPECT_EQ(topic.kind, FileKind::kImu) << topic.why;
  EXPECT_THAT(topic.columns, ElementsAre("skip", "skip", "t_ns", "skip", "skip", "skip", "skip",
                                         "skip", "wx", "wy", "wz", "fx", "fy", "fz"));
  EXPECT_EQ(topic.time_offset_s, 1694908782.0);
  const FileContent bag =
      imu("Time,header.seq,header.stamp.secs,header.stamp.nsecs,header.frame_id,orientation.x,"
          "orientation.y,orientation.z,orientation.w,angular_velocity.x,angular_velocity.y,"
          "angular_velocity.z,linear_acceleration.x,linear_acceleration.y,linear_acceleration.z\n",
          true);
  EXPECT_EQ(bag.kind, FileKind::kImu) << bag.why;
  EXPECT_THAT(bag.columns, ElementsAre("skip", "skip", "t", "nsec", "skip", "skip", "skip", "skip",
                                       "skip", "wx", "wy", "wz", "fx", "fy", "fz"));
  const FileContent fix = InspectText(
      "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.status.status,"
      "field.status.service,field.latitude,field.longitude,field.altitude,"
      "field.position_covariance0,field.position_covariance1\n" +
      Rows([](const CoursePose& p) {
        return fmt::format("{0},7,{0},gps,0,1,{1:.9f},{2:.9f},{3:.3f},0.01,0", Stamp(p), p.lat_deg,
                           p.lon_deg, p.h_m);
      }));
  EXPECT_EQ(fix.kind, FileKind::kGnss) << fix.why;
  EXPECT_THAT(fix.why, HasSubstr("'field.altitude' is above the ellipsoid"));
  EXPECT_THAT(fix.columns,
              ElementsAre("skip", "skip", "t_ns", "skip", "skip", "skip", "lat", "lon", "h"));
  const FileContent pose = InspectText(
      "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.pose.position.x,"
      "field.pose.position.y,field.pose.position.z,field.pose.orientation.x,"
      "field.pose.orientation.y,field.pose.orientation.z,field.pose.orientation.w\n" +
      Rows([](const CoursePose& p) {
        return fmt::format("{0},7,{0},odom,{1:.3f},{2:.3f},{3:.3f},{4}", Stamp(p),
                           p.east_m - 320000.0, p.north_m - 5150000.0, p.h_m,
                           EnuQuaternion(p, ","));
      }));
  EXPECT_EQ(pose.kind, FileKind::kTrajectory) << pose.why;
  EXPECT_THAT(pose.columns,
              ElementsAre("skip", "skip", "t_ns", "skip", "x", "y", "z", "qx", "qy", "qz", "qw"));
}

TEST(ContentExports, HeightsAboveTheSeaWithUndulation) {
  for (const char* header : {"time,latitude,longitude,height msl,undulation\n",
                             "time,lat,lon,altitude_above_msl (m),geoid separation (m)\n",
                             "t,Latitude,Longitude,MSL,Geoid_Height\n"}) {
    SCOPED_TRACE(header);
    std::string text = header;
    for (int i = 0; i < 100; ++i) {
      text += fmt::format("{},{:.8f},{:.8f},{:.3f},{:.2f}\n", 381000 + i, 46.5 + 1e-4 * i,
                          6.5 + 1e-4 * i, 450.0, 50.1);
    }
    const FileContent content = InspectText(text);
    EXPECT_EQ(content.kind, FileKind::kGnss) << content.why;
    EXPECT_THAT(content.columns, ElementsAre("t", "lat", "lon", "h", "undulation"));
  }
}

}  // namespace dn::files_test
