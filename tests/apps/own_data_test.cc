// Tests with data from other programs: dn must name what is unusual and how to correct it.
#include <dn/geo/point_crs.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

#include "damaged_flight.h"
#include "load_json.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

using Row = std::vector<double>;

/// Rewrites every row of a file of numbers and drops rows that `change` has emptied.
void EachRow(const DamagedFlight& flight, const std::string& name,
             const std::function<void(std::size_t, Row*)>& change) {
  const TextTable table = ReadTextTable(flight.path() / name, {});
  std::string text;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Row row(table.row(i), table.row(i) + table.columns);
    change(i, &row);
    for (std::size_t c = 0; c < row.size(); ++c) text += (c > 0 ? ", " : "") + FormatDouble(row[c]);
    if (!row.empty()) text += "\n";
  }
  flight.Write(name, text);
}

void Turn(const DamagedFlight& flight, const std::function<Row(const double*)>& axes) {
  EachRow(flight, "IMU.txt", [&](std::size_t, Row* row) {
    const Row w = axes(row->data() + 1), f = axes(row->data() + 4);
    *row = {(*row)[0], w[0], w[1], w[2], f[0], f[1], f[2]};
  });
}

Row Flu(const double* v) { return {v[0], -v[1], -v[2]}; }
Row Rfu(const double* v) { return {v[1], v[0], -v[2]}; }

std::string Checked(const DamagedFlight& flight) {
  return RunProgram({"check", flight.path().string()}).out;
}

TEST(OwnData, WellFormedDataGiveNoHint) {
  const DamagedFlight flight;
  EXPECT_THAT(Checked(flight), Not(HasSubstr("look at")));
  EXPECT_THAT(FileContent(SmoothResult() / "report.json"), Not(HasSubstr("R_imu_to_body")));
}

TEST(OwnData, ForwardLeftUpIsNamed) {
  const DamagedFlight flight;
  Turn(flight, Flu);
  EXPECT_THAT(Checked(flight),
              AllOf(HasSubstr("axes FLU"),
                    HasSubstr("imu.R_imu_to_body: [[1, 0, 0], [0, -1, 0], [0, 0, -1]]")));
}

TEST(OwnData, RightForwardUpIsNamedAndMended) {
  const DamagedFlight flight;
  Turn(flight, Rfu);
  const std::string matrix = "R_imu_to_body: [[0, 1, 0], [1, 0, 0], [0, 0, -1]]";
  EXPECT_THAT(Checked(flight), AllOf(HasSubstr("axes RFU"), HasSubstr("imu." + matrix)));
  flight.Replace("flight.yaml", "R_imu_to_body: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", matrix);
  EXPECT_THAT(Checked(flight), Not(HasSubstr("look at")));
}

TEST(OwnData, AnUpsideDownSensorIsNamedBySmooth) {
  const DamagedFlight flight;
  Turn(flight, Flu);
  const ProgramRun run = flight.Run("smooth");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("imu.R_imu_to_body: [[1, 0, 0], [0, -1, 0], [0, 0, -1]]"));
}

TEST(OwnData, LatitudeAndLongitudeExchanged) {
  const DamagedFlight flight;
  EachRow(flight, "GPS.txt", [](std::size_t, Row* row) { std::swap((*row)[1], (*row)[2]); });
  EXPECT_THAT(Checked(flight), HasSubstr("latitude and longitude may be exchanged"));
}

TEST(OwnData, CoordinatesInRadians) {
  const DamagedFlight flight;
  EachRow(flight, "GPS.txt", [](std::size_t, Row* row) {
    for (const int c : {1, 2}) (*row)[c] *= std::acos(-1.0) / 180.0;
  });
  EXPECT_THAT(Checked(flight), HasSubstr("look like radians"));
}

TEST(OwnData, UtcForGpsTimeIsNamedAndMended) {
  const DamagedFlight flight;
  EachRow(flight, "GPS.txt", [](std::size_t, Row* row) { (*row)[0] -= 18.0; });
  EXPECT_THAT(Checked(flight), AllOf(HasSubstr("in UTC"), HasSubstr("gnss.time_offset_s: -18")));
  flight.Replace("flight.yaml", "format: odyn\n  time_offset_s: 0",
                 "format: odyn\n  time_offset_s: -18");
  EXPECT_THAT(Checked(flight), Not(HasSubstr("look at")));
}

/// Writes the trajectory of a flight as text, with changed rows: t, lat, lon, h, quaternion.
void WriteTrajectory(const DamagedFlight& flight, const std::function<void(Row*)>& change) {
  std::vector<NavPoint> points;
  const Trajectory smoothed = ReadTrajectory(SmoothResult() / "trajectory.out");
  for (const NavPoint& point : smoothed.points()) {
    if (points.empty() || point.t_s - points.back().t_s > 0.095) points.push_back(point);
  }
  flight.Write("trajectory.txt", FormatTrajectoryText(points));
  EachRow(flight, "trajectory.txt", [&](std::size_t, Row* row) { change(row); });
}

TEST(OwnData, ATrajectoryOfTheFlightGivesNoHint) {
  const DamagedFlight flight;
  WriteTrajectory(flight, [](Row*) {});
  EXPECT_THAT(Checked(flight), Not(HasSubstr("look at")));
}

TEST(OwnData, ATrajectoryInUtcIsNamedAndNotThePairs) {
  for (const double offset_s : {-18.0, 86400.0}) {
    const DamagedFlight flight;
    WriteTrajectory(flight, [&](Row* row) { (*row)[0] += offset_s; });
    const std::string remedy = offset_s < 0.0 ? "Add 18 s to the times of the trajectory"
                                              : "Subtract 86400 s from the times of the trajectory";
    EXPECT_THAT(Checked(flight), AllOf(HasSubstr(remedy), Not(HasSubstr("lidar.time_offset_s"))));
    const ProgramRun run = flight.Run("calibrate", {"--method", "gh"});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, AllOf(HasSubstr(remedy), Not(HasSubstr("lidar.time_offset_s"))));
  }
}

TEST(OwnData, CoordinatesOfATrajectoryAreComparedWithGnss) {
  const auto named = [](const std::function<void(Row*)>& change) {
    const DamagedFlight flight;
    WriteTrajectory(flight, change);
    return Checked(flight);
  };
  EXPECT_THAT(named([](Row* row) { std::swap((*row)[1], (*row)[2]); }),
              AllOf(HasSubstr("trajectory.columns: [t, lon, lat, h, qw, qx, qy, qz]"),
                    Not(HasSubstr("trajectory.attitude"))));
  EXPECT_THAT(named([](Row* row) {
                for (const int c : {1, 2}) (*row)[c] *= kRadPerDeg;
              }),
              HasSubstr("trajectory.columns: [t, lat_rad, lon_rad, h, qw, qx, qy, qz]"));
  EXPECT_THAT(named([](Row* row) { (*row)[3] -= 48.0; }), HasSubstr("below the GNSS positions"));
  EXPECT_THAT(named([](Row* row) { (*row)[3] /= 0.3048; }), HasSubstr("in feet"));
  EXPECT_THAT(named([](Row* row) { (*row)[1] += 0.5; }), HasSubstr("lies 55.6 km from"));
}

TEST(OwnData, BodyAxesOfATrajectoryAreComparedWithTheGyros) {
  const DamagedFlight flight;
  WriteTrajectory(flight, [](Row* row) {  // times the half turn from forward-left-up
    const Row q(row->begin() + 4, row->end());
    *row = {(*row)[0], (*row)[1], (*row)[2], (*row)[3], -q[1], q[0], q[3], -q[2]};
  });
  const std::string columns = "columns: [t, lat, lon, h, qx, -qw, -qz, qy]";
  EXPECT_THAT(Checked(flight), AllOf(HasSubstr("body axes FLU"), HasSubstr(columns)));
  flight.Write("flight.yaml", FileContent(flight.path() / "flight.yaml") +
                                  "trajectory: {file: trajectory.txt, " + columns + "}\n");
  EXPECT_THAT(Checked(flight), Not(HasSubstr("look at")));
}

TEST(OwnData, FullGpsSecondsAreNamed) {
  const DamagedFlight flight;
  EachRow(flight, "GPS.txt", [](std::size_t, Row* row) { (*row)[0] += 1419465600.0; });
  const ProgramRun run = RunProgram({"check", flight.path().string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("GPS time since 1980"));
}

TEST(OwnData, AnOriginFarAway) {
  const DamagedFlight flight;
  flight.Write("flight.yaml", flight.Read("flight.yaml") + "\n");
  const std::string yaml = flight.Read("flight.yaml");
  const std::size_t at = yaml.find("origin_deg_m: ");
  ASSERT_NE(at, std::string::npos);
  std::string other = yaml;
  other.replace(at, yaml.find_first_of("]~", at) + 1 - at, "origin_deg_m: [6.52, 46.57, 0]");
  flight.Write("flight.yaml", other);
  EXPECT_THAT(Checked(flight), HasSubstr("frame.origin_deg_m lies"));
}

TEST(OwnData, RowsThatRepeatTheValuesBeforeAreCounted) {
  const DamagedFlight flight;
  Row before;
  EachRow(flight, "IMU.txt", [&](std::size_t i, Row* row) {
    if (i % 3 == 2) std::copy(before.begin() + 1, before.end(), row->begin() + 1);
    before = *row;
  });
  EXPECT_THAT(Checked(flight), HasSubstr("(33 %) repeat the values of the row before"));
}

// A logger may write means over one to three intervals. These are data without gaps, and the result
// must be as good as with even rows.
TEST(OwnData, UnevenRowsAreSmoothed) {
  const DamagedFlight flight;
  Row sum;
  std::size_t begin = 0, length = 1;
  EachRow(flight, "IMU.txt", [&](std::size_t i, Row* row) {
    if (i == begin) sum.assign(row->size(), 0.0);
    for (std::size_t c = 1; c < row->size(); ++c) sum[c] += (*row)[c];
    if (i + 1 < begin + length) return row->clear();
    for (std::size_t c = 1; c < row->size(); ++c) {
      (*row)[c] = sum[c] / static_cast<double>(length);
    }
    begin = i + 1;
    length = 1 + (i / 2) % 3;
  });
  EXPECT_THAT(Checked(flight), AllOf(HasSubstr("uneven, jitter up to"), HasSubstr("no gap")));
  const ProgramRun run = flight.Run("smooth");
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST(OwnData, EveryProblemIsTold) {
  const DamagedFlight flight;
  flight.ReplaceLine("IMU.txt", 7, "381000.14, 0, 0, 0, 0, 0");
  flight.ReplaceLine("GPS.txt", 3, "381002, 46.5");
  const ProgramRun run = flight.Run("check");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, AllOf(HasSubstr("IMU.txt:7"), HasSubstr("GPS.txt:3"), HasSubstr("pairs")));
  EXPECT_THAT(FileContent(flight.out() / "report.json"),
              AllOf(HasSubstr("GPS.txt:3"), HasSubstr("\"counts\"")));
}

TEST(OwnDataManyRuns, AFailedRunKeepsWhatIsKnown) {
  const DamagedFlight flight;
  EachRow(flight, "GPS.txt", [](std::size_t i, Row* row) {
    if (i % 2 == 0) (*row)[3] += 500.0;
  });
  const ProgramRun run = flight.Run("smooth");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(FileContent(flight.out() / "report.json"),
              AllOf(HasSubstr("\"gnss epochs\""), HasSubstr("\"read\"")));
  EXPECT_THAT(FileContent(flight.out() / "report.html"),
              AllOf(HasSubstr("refused"), HasSubstr("What was tried"), HasSubstr("gnss epochs")));
}

/// A folder that contains only the raw logs of the short flight, modified by `change`.
class RawFolder {
 public:
  explicit RawFolder(const std::function<void(const DamagedFlight&)>& change = {}) {
    if (change) change(flight_);
    for (const char* name : {"IMU.txt", "GPS.txt"}) {
      folder_.Write(std::string("raw/") + name, flight_.Read(name));
    }
  }
  void Write(const std::string& name, const std::string& text) const {
    folder_.Write("raw/" + name, text);
  }

  std::string path() const { return (folder_.path() / "raw").string(); }
  std::string out() const { return (folder_.path() / "out").string(); }
  std::string Yaml() const { return FileContent(folder_.path() / "raw/flight.yaml"); }

 private:
  DamagedFlight flight_;
  TempFolder folder_;
};

TEST(CliInit, FromLogsToATrajectoryInThreeCommands) {
  const RawFolder raw;
  const ProgramRun init = RunProgram({"init", raw.path()});
  EXPECT_EQ(init.exit_code, 0) << init.err;
  EXPECT_THAT(init.out, AllOf(HasSubstr("inertial data"), HasSubstr("missing  gnss.lever_arm_m")));
  EXPECT_THAT(raw.Yaml(), AllOf(HasSubstr("50.00 Hz"), HasSubstr("grade: unknown"),
                                HasSubstr("unmodelled: {gnss_lever_arm: 0.5}")));
  EXPECT_EQ(RunProgram({"check", raw.path()}).exit_code, 0);
  RunProgram({"smooth", raw.path(), "--out", raw.out()});
  EXPECT_TRUE(fs::exists(fs::path(raw.out()) / "trajectory.out"));
  EXPECT_GE(LoadJson(fs::path(raw.out()) / "smooth.json")["noise"].size(), 4u);
}

TEST(CliInit, SettlesAxesUnitsAndClocks) {
  const RawFolder raw([](const DamagedFlight& flight) {
    Turn(flight, Rfu);
    EachRow(flight, "IMU.txt", [](std::size_t, Row* row) {
      for (const int c : {4, 5, 6}) (*row)[c] /= 9.80665;
    });
    EachRow(flight, "GPS.txt", [](std::size_t, Row* row) { (*row)[0] += 1419465600.0 - 18.0; });
  });
  const ProgramRun init = RunProgram({"init", raw.path()});
  EXPECT_EQ(init.exit_code, 0) << init.err;
  EXPECT_THAT(raw.Yaml(), AllOf(HasSubstr("force_unit: g"), HasSubstr("time_offset_s: 1419465582"),
                                HasSubstr("R_imu_to_body: [[0, 1, 0], [1, 0, 0], [0, 0, -1]]")));
  const ProgramRun check = RunProgram({"check", raw.path()});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_THAT(check.out, Not(HasSubstr("look at")));
}

/// Returns a trajectory as another program may write it: grid coordinates, roll, pitch, and yaw
/// counter-clockwise from east.
std::string GridTrajectory(const std::string& gps, std::size_t rows) {
  const TextTable table = ReadTextTable(gps, {});
  const LocalFrame frame({46.57 / kDegPerRad, 6.52 / kDegPerRad, 400.0});
  const PointCrs grid("utm:32n", frame);
  std::vector<Eigen::Vector3d> p_m;
  for (std::size_t i = 0; i < rows; ++i) {
    const double* row = table.row(i);
    p_m.push_back(grid.FromMap(frame.ToMap({row[1] / kDegPerRad, row[2] / kDegPerRad, row[3]})));
  }
  std::string text;
  for (std::size_t i = 0; i + 1 < rows; ++i) {
    const Eigen::Vector3d by_m = p_m[i + 1] - p_m[i];
    text += FormatDouble(table.row(i)[0]);
    for (const double x : p_m[i]) text += ", " + FormatDouble(x);
    text += ", 1, 2, " + FormatDouble(std::atan2(by_m.y(), by_m.x()) * kDegPerRad) + "\n";
  }
  return text;
}

TEST(CliInit, SaysWhatTheColumnsOfATrajectoryAre) {
  const RawFolder raw([](const DamagedFlight& flight) {
    flight.Write("IMU.txt", GridTrajectory((flight.path() / "GPS.txt").string(), 250));
  });
  const ProgramRun init = RunProgram({"init", raw.path()});
  EXPECT_EQ(init.exit_code, 0) << init.err;
  EXPECT_THAT(raw.Yaml(),
              AllOf(HasSubstr("crs: utm:32n"), HasSubstr("attitude: roll_pitch_yaw_enu_deg")));
  const ProgramRun check = RunProgram({"check", raw.path()});
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
  EXPECT_THAT(check.out, HasSubstr("trajectory points: 249"));
}

TEST(CliInit, AGridWithoutAZoneIsNoFlightYet) {
  const RawFolder raw([](const DamagedFlight& flight) {
    flight.Write("IMU.txt", GridTrajectory((flight.path() / "GPS.txt").string(), 250));
  });
  fs::remove(fs::path(raw.path()) / "GPS.txt");
  const ProgramRun init = RunProgram({"init", raw.path()});
  EXPECT_THAT(init.out, HasSubstr("missing  trajectory.crs: the zone of the grid"));
  const ProgramRun check = RunProgram({"check", raw.path()});
  EXPECT_EQ(check.exit_code, 2);
  EXPECT_THAT(check.err, AllOf(HasSubstr("flight.yaml:"), HasSubstr("utm:ZONEn")));
}

TEST(CliInit, AnOddFileDoesNotStopTheRest) {
  const RawFolder raw;
  const std::string folder = raw.path();
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(fs::path(folder) / name) << text;
  };
  write("a.nmea", "$GPGGA,094942.00,4630.0,N,00630.0,E,4,12,0.8,450.0,M,50.0,M,1.0,0001\n");
  write("b.pos", "%  GPST  latitude(deg) longitude(deg)  height(m)\n2280 381000.0 46.5 nan 500\n");
  write("c.log", "$VNIMU,-02.1,+00.4,+01.3*5F\n");
  write("d.csv", "time,note\n");
  const ProgramRun init = RunProgram({"init", folder});
  EXPECT_EQ(init.exit_code, 0) << init.err;
  for (const char* name : {"a.nmea", "b.pos", "c.log", "d.csv"}) {
    EXPECT_THAT(init.out, HasSubstr(std::string("note     ") + name)) << init.out;
  }
  EXPECT_THAT(raw.Yaml(), AllOf(HasSubstr("\"GPS.txt\""), HasSubstr("\"IMU.txt\"")));
  EXPECT_EQ(RunProgram({"check", folder}).exit_code, 0);
}

// A log with a header, acceleration first, in other units, with a clock in milliseconds.
TEST(CliInit, NamesTheColumnsOfALog) {
  const RawFolder raw([](const DamagedFlight& flight) {
    EachRow(flight, "IMU.txt", [](std::size_t, Row* row) {
      const Row r = *row;
      *row = {1e3 * r[0], r[4], r[5], r[6], r[1], r[2], r[3], 22, 5, -43};
    });
    flight.Write("IMU.txt", "Time_ms,AccX,AccY,AccZ,GyroX,GyroY,GyroZ,MagX,MagY,MagZ\n" +
                                flight.Read("IMU.txt"));
  });
  const ProgramRun init = RunProgram({"init", raw.path()});
  EXPECT_EQ(init.exit_code, 0) << init.err;
  EXPECT_THAT(raw.Yaml(), HasSubstr("columns: [t_ms, fx, fy, fz, wx, wy, wz]"));
  const ProgramRun check = RunProgram({"check", raw.path()});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_THAT(check.out, Not(HasSubstr("look at")));
}

// A second unit on the body, turned about x, with a clock of its own.
TEST(CliInit, ComparesTwoInertialUnits) {
  const DamagedFlight turned;
  EachRow(turned, "IMU.txt", [](std::size_t, Row* row) {
    for (const int c : {2, 3, 5, 6}) (*row)[c] *= -1.0;
    (*row)[0] += 100.0;
  });
  const RawFolder raw;
  raw.Write("second.txt", turned.Read("IMU.txt"));
  const ProgramRun init = RunProgram({"init", raw.path()});
  EXPECT_EQ(init.exit_code, 0) << init.err;
  EXPECT_THAT(init.out,
              HasSubstr("settled  second.txt shows the rotations of IMU.txt: its tags are 100"));
  EXPECT_THAT(init.out, HasSubstr("turned by 180"));
}

/// Returns inertial data and GNSS positions in one table. The rows without a new position have
/// nothing, zeros or the last position in its place.
std::string OneTable(const RawFolder& raw, const std::string& between) {
  const TextTable imu = ReadTextTable(raw.path() + "/IMU.txt", {});
  const TextTable gps = ReadTextTable(raw.path() + "/GPS.txt", {});
  std::string text = "t,gx,gy,gz,ax,ay,az,lat,lon,alt\n", position = ",0,0,0";
  for (std::size_t i = 0, k = 1; i < imu.rows(); ++i) {
    for (std::size_t c = 0; c < 7; ++c) text += (c > 0 ? "," : "") + FormatDouble(imu.row(i)[c]);
    const bool is_new = k < gps.rows() && gps.row(k)[0] <= imu.row(i)[0] + 1e-6;
    if (is_new) {
      position.clear();
      for (std::size_t c = 1; c < 4; ++c) position += "," + FormatDouble(gps.row(k)[c]);
      ++k;
    }
    text += (is_new || between == "held" ? position : between) + "\n";
  }
  return text;
}

TEST(CliInit, OneTableMayHaveInertialDataAndPositions) {
  for (const char* between : {",,,", ",0,0,0", ",nan,nan,nan", "held"}) {
    SCOPED_TRACE(between);
    const RawFolder raw;
    raw.Write("log.csv", OneTable(raw, between));
    for (const char* name : {"IMU.txt", "GPS.txt"}) fs::remove(fs::path(raw.path()) / name);
    const ProgramRun init = RunProgram({"init", raw.path()});
    EXPECT_EQ(init.exit_code, 0) << init.err;
    EXPECT_THAT(raw.Yaml(), AllOf(HasSubstr("rows: changed"), HasSubstr("lat, lon, h]")));
    const ProgramRun check = RunProgram({"check", raw.path()});
    EXPECT_THAT(check.out, AllOf(HasSubstr("1.00 Hz"), HasSubstr("verdict         ready")));
  }
}

// The log of a flight controller, whose clock began with the flight.
TEST(CliInit, AttitudesInALogSettleItsClock) {
  const Trajectory smoothed = ReadTrajectory(SmoothResult() / "trajectory.out");
  const RawFolder raw([](const DamagedFlight& flight) { Turn(flight, Rfu); });
  std::string log =
      "time(millisecond),latitude,longitude,altitude(meters),compass_heading(degrees),"
      "pitch(degrees),roll(degrees)\n";
  double before_s = -1.0;
  for (const NavPoint& point : smoothed.points()) {
    if (point.t_s - before_s < 0.195) continue;
    before_s = point.t_s;
    const Eigen::Matrix3d R = point.q_nb.toRotationMatrix();
    const auto angle = [](double rad) {
      return "," + FormatDouble(std::round(10.0 * rad * kDegPerRad) / 10.0);
    };
    log += FormatDouble(std::round(1e3 * (point.t_s - 380000.0))) + "," +
           FormatDouble(point.position.lat_rad * kDegPerRad) + "," +
           FormatDouble(point.position.lon_rad * kDegPerRad) + "," +
           FormatDouble(point.position.h_m) + angle(std::atan2(R(1, 0), R(0, 0)) + 1.5) +
           angle(-std::asin(R(2, 0))) + angle(std::atan2(R(2, 1), R(2, 2))) + "\n";
  }
  raw.Write("log.csv", log);
  fs::remove(fs::path(raw.path()) / "GPS.txt");
  const ProgramRun init = RunProgram({"init", raw.path()});
  EXPECT_EQ(init.exit_code, 0) << init.err;
  EXPECT_THAT(init.out, AllOf(HasSubstr("the attitudes in log.csv show the rotations of IMU.txt"),
                              HasSubstr("axes are parallel")));
  EXPECT_THAT(raw.Yaml(), AllOf(HasSubstr("time_offset_s: -380000"),
                                HasSubstr("[[0, 1, 0], [1, 0, 0], [0, 0, -1]]"),
                                HasSubstr("from the attitudes of the GNSS file")));
}

// An RTKLIB solution whose header names the wrong time system.
TEST(CliInit, ASolutionInUtcIsSettled) {
  const DamagedFlight flight;
  std::string solution =
      "%  GPST  latitude(deg) longitude(deg) height(m)  Q  ns  sdn(m)  sde(m)  sdu(m)\n";
  EachRow(flight, "GPS.txt", [&](std::size_t, Row* row) {
    const Row& r = *row;
    solution += "2280 " + FormatDouble(r[0] - 18.0);
    for (const int c : {1, 2, 3}) solution += " " + FormatDouble(r[c]);
    solution += " 1 12 0.015 0.015 0.03\n";
  });
  const RawFolder raw;
  raw.Write("rover.pos", solution);
  fs::remove(fs::path(raw.path()) / "GPS.txt");
  const ProgramRun init = RunProgram({"init", raw.path()});
  EXPECT_EQ(init.exit_code, 0) << init.err;
  EXPECT_THAT(init.out, HasSubstr("are the GNSS tags in UTC, which is 18 s behind GPS time?"));
  EXPECT_THAT(raw.Yaml(), HasSubstr("time_offset_s: -18"));
  EXPECT_THAT(RunProgram({"check", raw.path()}).out, Not(HasSubstr("look at")));
}

TEST(CliInit, LeavesAFlightYamlAsItIs) {
  const RawFolder raw;
  EXPECT_EQ(RunProgram({"init", raw.path()}).exit_code, 0);
  const ProgramRun again = RunProgram({"init", raw.path()});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.err, HasSubstr("left as it is"));
}

TEST(CliInit, AFolderWithoutDataIsListedWithWhatIsMissing) {
  const TempFolder folder;
  folder.Write("readme.txt", "hello\n");
  folder.Write("strip.las", "LASF" + std::string(400, ' '));
  const ProgramRun run = RunProgram({"init", folder.path().string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, AllOf(HasSubstr("readme.txt is not used: "),
                             HasSubstr("found    strip.las              a point cloud")));
  EXPECT_THAT(run.err, HasSubstr("add a trajectory, or inertial data and GNSS positions"));
  EXPECT_FALSE(fs::exists(folder.path() / "flight.yaml"));
}

TEST(CliInit, AFileThatCannotBeReadHasOneLineWithTheReason) {
  const RawFolder raw;
  raw.Write("second.txt", FileContent(fs::path(raw.path()) / "IMU.txt"));
  fs::remove(fs::path(raw.path()) / "IMU.txt");
  std::string rows;
  for (int i = 0; i < 5000; ++i) {
    rows += std::to_string(381000 + 0.01 * i) + " 0.01 0.02 0.03 0.1 0.2 -9.8\n";
  }
  raw.Write("first.txt", rows + "381060 0.01 broken 0.1 0.1 0.2 -9.8\n");
  const ProgramRun run = RunProgram({"init", raw.path()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("first.txt is not used: "));
  EXPECT_EQ(run.out.find("first.txt"), run.out.rfind("first.txt")) << run.out;
  EXPECT_THAT(run.out, Not(HasSubstr("also contains")));
  EXPECT_THAT(raw.Yaml(), HasSubstr("file: \"second.txt\""));
}

TEST(OwnData, NoiseWithoutADataSheetIsEstimatedAndListed) {
  const DamagedFlight flight;
  const ProgramRun smooth = flight.Run("smooth", {"--set", "imu.grade=unknown"});
  EXPECT_EQ(smooth.exit_code, 0) << smooth.err;
  EXPECT_THAT(smooth.out, HasSubstr("noise estimated from the data"));
  const Json noise = LoadJson(flight.out() / "smooth.json")["noise"];
  ASSERT_GE(noise.size(), 4u);
  EXPECT_EQ(noise[0]["name"], "imu.gyro.white");
  EXPECT_GT(noise[0]["sigma"].get<double>(), 0.0);
  EXPECT_THAT(FileContent(flight.out() / "config.resolved.yaml"),
              HasSubstr("velocity_sigma_scale: ~"));
  EXPECT_TRUE(LoadJson(SmoothResult() / "smooth.json")["noise"].is_null());
}

TEST(OwnData, ADesignNeedsFiguresOfTheNoise) {
  const DamagedFlight flight;
  flight.Replace("flight.yaml", "grade: \"airins\"", "grade: unknown");
  EXPECT_EQ(flight.Run("study", {"--no-remedies", "--no-limits"}).exit_code, 0);
  std::string text = flight.Read("flight.yaml");
  const std::size_t figures = text.find("  gyro:\n");
  text.erase(figures, text.find("  vibration:") - figures);
  flight.Write("flight.yaml", text);
  const ProgramRun without = flight.Run("study");
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_THAT(without.err, HasSubstr("imu.gyro and imu.accel"));
}

}  // namespace dn::testing::apps_test
