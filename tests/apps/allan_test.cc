#include <dn/files/flight_config.h>
#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <random>

#include "page_numbers.h"
#include "run_program.h"
#include "static_record.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

ProgramRun Allan(const TempFolder& folder, const std::string& rate = "50") {
  return RunProgram({"allan", (folder.path() / "IMU.txt").string(), "--rate", rate, "--out",
                     (folder.path() / "out").string()});
}

TEST(CliAllan, FindsTheWhiteNoiseAndNothingElse) {
  const TempFolder folder;
  folder.Write("IMU.txt", StaticRecord(1200));
  const ProgramRun run = Allan(folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(FileContent(folder.path() / "out/allan.json"));
  EXPECT_EQ(json["schema"], "dn.allan/1");
  EXPECT_NEAR(json["gyro"]["model"]["white"]["value"], kArw_deg_sqrt_h, 0.02 * kArw_deg_sqrt_h);
  EXPECT_EQ(json["gyro"]["model"]["white"]["unit"], "deg/sqrt(h)");
  EXPECT_NEAR(json["accel"]["model"]["white"]["value"], kVrw_m_s_sqrt_h, 0.02 * kVrw_m_s_sqrt_h);
  EXPECT_TRUE(json["gyro"]["model"]["gauss_markov"].is_null());
  EXPECT_TRUE(json["accel"]["model"]["random_walk"].is_null());
  EXPECT_EQ(json["gyro"]["x"]["curve"]["tau_s"].size(),
            json["gyro"]["x"]["curve"]["deviation"].size());
  ExpectPageMatchesFiles(folder.path() / "out", 4);
  for (const char* name : {"allan.csv", "noise.yaml", "config.resolved.yaml", "report.json"}) {
    EXPECT_TRUE(fs::exists(folder.path() / "out" / name)) << name;
  }
}

TEST(CliAllan, ItsNoiseGoesIntoAFlightAsItIs) {
  const TempFolder folder;
  folder.Write("IMU.txt", StaticRecord(600));
  ASSERT_EQ(Allan(folder).exit_code, 0);
  const std::string text = "name: pasted\n" + FileContent(folder.path() / "out/noise.yaml");
  const FlightConfig config = ParseFlightConfig(text, folder.path());
  ASSERT_TRUE(config.imu);
  EXPECT_NEAR(config.imu->model.accel.white * 60.0, kVrw_m_s_sqrt_h, 0.03 * kVrw_m_s_sqrt_h);
  EXPECT_TRUE(config.imu->model.gyro.processes.empty());
}

// The same record with other units, accelerations first and time in microseconds.
TEST(CliAllan, TakesUnitsAndColumns) {
  const TempFolder folder;
  const std::string record = StaticRecord(600);
  folder.Write("IMU.txt", record);
  std::string other = "time (us),acc x,acc y,acc z,gyr x,gyr y,gyr z\n";
  double t = 0.0, w[3], f[3];
  for (std::size_t at = 0; at < record.size(); at = record.find('\n', at) + 1) {
    ASSERT_EQ(std::sscanf(record.c_str() + at, "%lf,%lf,%lf,%lf,%lf,%lf,%lf", &t, &w[0], &w[1],
                          &w[2], &f[0], &f[1], &f[2]),
              7);
    char row[200];
    constexpr double kDeg = 180.0 / std::numbers::pi, kG = 9.80665;
    std::snprintf(row, sizeof row, "%.0f,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n", 1e6 * t, f[0] / kG,
                  f[1] / kG, f[2] / kG, kDeg * w[0], kDeg * w[1], kDeg * w[2]);
    other += row;
  }
  folder.Write("other.csv", other);
  const auto run = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"allan", (folder.path() / name).string(), "--rate", "50",
                                       "--out", (folder.path() / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  };
  const auto white = [&](const char* sensor) {
    const Json json = Json::parse(FileContent(folder.path() / "out/allan.json"));
    return json[sensor]["model"]["white"]["value"].get<double>();
  };
  ASSERT_EQ(run("IMU.txt", {}).exit_code, 0);
  const double gyro = white("gyro"), accel = white("accel");
  const ProgramRun units = run("other.csv", {"--rate-unit", "deg/s", "--force-unit", "g",
                                             "--columns", "t_us,fx,fy,fz,wx,wy,wz"});
  ASSERT_EQ(units.exit_code, 0) << units.err;
  EXPECT_NEAR(white("gyro"), gyro, 1e-5 * gyro);
  EXPECT_NEAR(white("accel"), accel, 1e-5 * accel);
  EXPECT_EQ(run("IMU.txt", {"--rate-unit", "rpm"}).exit_code, 2);
  EXPECT_EQ(run("IMU.txt", {"--columns", "t,ax"}).exit_code, 2);
  EXPECT_EQ(run("other.csv", {"--rate-unit", "deg/s"}).exit_code, 1);
}

TEST(CliAllan, BadRecordsAreRefused) {
  const TempFolder folder;
  folder.Write("IMU.txt", StaticRecord(600));
  const ProgramRun rate = Allan(folder, "100");
  EXPECT_EQ(rate.exit_code, 2);
  EXPECT_THAT(rate.err, HasSubstr("--rate 100 Hz, but the time tags"));
  EXPECT_THAT(rate.err, HasSubstr("50 Hz"));
  folder.Write("IMU.txt", StaticRecord(600, 5000));
  const ProgramRun gap = Allan(folder);
  EXPECT_EQ(gap.exit_code, 1);
  EXPECT_THAT(gap.err, HasSubstr("1 gaps in the record, the first from 1100.000"));
  folder.Write("IMU.txt", StaticRecord(3));
  const ProgramRun few = Allan(folder);
  EXPECT_EQ(few.exit_code, 1);
  EXPECT_THAT(few.err, HasSubstr("too short"));
  EXPECT_EQ(NamesIn(folder.path() / "out"), std::vector<std::string>{"report.json"});
}

TEST(CliAllan, MotionIsRefused) {
  const TempFolder folder;
  folder.Write("IMU.txt", StaticRecord(600, -1, 0.1));
  const ProgramRun run = Allan(folder);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("gyro z: the sensor was not at rest"));
}

// Uses the first 2,000 s of a measured record of 16-bit integers, described in its README.md.
TEST(CliAllan, MeasuredSensor) {
  const fs::path packed = fs::path(DN_SHARED_DATA_DIR) / "data/adis16405/adis16405_run1.i16.xz";
  if (!fs::exists(packed)) GTEST_SKIP() << "no measured data: " << packed;
  constexpr double kRadpsPerBit = 0.05 * std::numbers::pi / 180.0, kMps2PerBit = 0.00333 * 9.80665;
  FILE* pipe = popen(("xz -dc '" + packed.string() + "' 2>/dev/null").c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string text;
  std::array<std::int16_t, 6> bits{};
  char row[200];
  for (int k = 0; k < 200000 && std::fread(bits.data(), 2, 6, pipe) == 6; ++k) {
    std::snprintf(row, sizeof row, "%.2f,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", 1000.0 + (k + 1) / 100.0,
                  kRadpsPerBit * bits[0], kRadpsPerBit * bits[1], kRadpsPerBit * bits[2],
                  kMps2PerBit * bits[3], kMps2PerBit * bits[4], kMps2PerBit * bits[5]);
    text += row;
  }
  pclose(pipe);
  if (text.empty()) GTEST_SKIP() << "xz is not installed";
  const TempFolder folder;
  folder.Write("IMU.txt", text);
  const ProgramRun run = Allan(folder, "100");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json model = Json::parse(FileContent(folder.path() / "out/allan.json"))["gyro"]["model"];
  // Independent results for this record: about 2.5 deg/sqrt(h) and a floor of 25 to 30 deg/h.
  EXPECT_NEAR(model["white"]["value"], 2.5, 0.25);
  EXPECT_NEAR(model["floor"]["deviation"], 27.0, 6.0);
}

}  // namespace dn::testing::apps_test
