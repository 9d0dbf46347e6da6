// Each test has one error of flight.yaml and checks the message and its line.
#include <dn/files/flight_config.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "testing/expect_invalid.h"
#include "testing/hostile_yaml.h"
#include "testing/temp_folder.h"

namespace dn::files_test {

using testing::ExpectInvalid;
using testing::TempFolder;

/// Expects InvalidConfig with the name of the file for a text with an error on `line`.
void ExpectBad(const std::string& text, const std::string& what, long line) {
  SCOPED_TRACE(text);
  const auto parse = [&] { ParseFlightConfig(text, "/f"); };
  ExpectInvalid(parse, what, line);
  try {
    parse();
  } catch (const InvalidConfig& e) {
    EXPECT_EQ(e.where().file, "/f/flight.yaml");
  }
}

TEST(FlightConfigErrors, MissingFolder) {
  ExpectInvalid([] { ReadFlightConfig("/nowhere/flight"); }, "'/nowhere/flight'", 0);
}

TEST(FlightConfigErrors, MissingFile) {
  const TempFolder folder;
  EXPECT_THROW(ReadFlightConfig(folder.path()), InvalidConfig);
}

TEST(FlightConfigErrors, EmptyFile) { ExpectBad("", "empty", 1); }
TEST(FlightConfigErrors, NoMap) { ExpectBad("- a\n- b\n", "expected a map", 1); }
TEST(FlightConfigErrors, Syntax) { ExpectBad("name: a\nbody: [FRD\n", "not valid YAML", 3); }

TEST(FlightConfigErrors, UnknownKeyNamesTheNearest) {
  ExpectBad("name: a\nlidr: {}\n", "unknown key 'lidr'; did you mean 'lidar'?", 2);
  ExpectBad("gnss:\n  file: a\n  lever_arm: [0, 0, 0]\n",
            "gnss: unknown key 'lever_arm'; did you mean 'lever_arm_m'?", 3);
  ExpectBad("lidar:\n  gsd_m: 1\n  pairs: {strateg: all}\n", "did you mean 'strategy'?", 3);
}

TEST(FlightConfigErrors, KeyGivenTwice) {
  ExpectBad("gnss:\n  file: a\n  file: b\n", "'file' is given twice", 3);
}

TEST(FlightConfigErrors, WrongType) {
  ExpectBad("gnss:\n  sigma_scale: big\n", "gnss.sigma_scale: expected a number, found 'big'", 2);
  ExpectBad("gnss:\n  sigma_scale: 1m\n", "expected a number, found '1m'", 2);
  ExpectBad("gnss:\n  sigma_scale: [1]\n", "expected a number, found a list of 1", 2);
  ExpectBad("gnss: 5\n", "gnss: expected a map", 1);
  ExpectBad("gh: {libor_compat: 3}\n", "expected true or false", 1);
  ExpectBad("name: [a]\n", "name: expected a word", 1);
  ExpectBad("strips: 3\n", "strips: expected a list", 1);
}

TEST(FlightConfigErrors, WrongShape) {
  ExpectBad("gnss:\n  lever_arm_m: [0, 0]\n", "expected a list of 3 numbers, found a list of 2", 2);
  ExpectBad("lidar:\n  R_sensor_to_body: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n", "3 x 3 matrix", 2);
  ExpectBad("time_span_s: [1]\n", "a list of 2 numbers", 1);
}

TEST(FlightConfigErrors, ChangedRowsNeedColumns) {
  ExpectBad("gnss:\n  rows: changed\n", "changed needs columns", 2);
  ExpectBad("gnss:\n  rows: new\n", "'new' is not one of all, changed", 2);
}

TEST(FlightConfigErrors, OutOfRange) {
  ExpectBad("gnss:\n  sigma_scale: 0\n", "must be greater than 0, is 0", 2);
  ExpectBad("gnss:\n  velocity_sigma_scale: 0\n", "must be greater than 0, is 0", 2);
  ExpectBad("gnss:\n  sigma_scale: inf\n", "must be finite", 2);
  ExpectBad("gnss: {sigma_enu_m: [1, 0, 1]}\n", "every element must be greater than 0", 1);
  ExpectBad("frame: {origin_deg_m: [91, 0, 0]}\n", "latitude", 1);
  ExpectBad("frame: {origin_deg_m: [0, 400, 0]}\n", "longitude", 1);
  ExpectBad("time_span_s: [2, 1]\n", "must begin before it ends", 1);
  ExpectBad("trajectory: {sigma_rp_deg: -1}\n", "trajectory.sigma_rp_deg: must be greater", 1);
  ExpectBad("trajectory: {crs: utm:61n}\n", "is not one of geographic, map, utm:ZONEn", 1);
  ExpectBad("gnss: {crs: utm:61n}\n", "is not one of geographic, map, utm:ZONEn", 1);
  ExpectBad("gnss: {north: grid}\n", "grid needs coordinates in a UTM grid", 1);
  ExpectBad("gnss: {format: rtklib, crs: utm:32n}\n", "define their coordinates themselves", 1);
  ExpectBad("trajectory: {north: grid}\n", "grid needs coordinates in a UTM grid", 1);
  ExpectBad("network: {node_rate_hz: -1}\n", "greater than 0", 1);
  ExpectBad("lidar: {gsd_m: 1, pairs: {strategy: max, count: 0}}\n", "at least 1", 1);
  ExpectBad("lidar: {gsd_m: 1, pairs: {seed: -1}}\n", "at least 0", 1);
  ExpectBad("lidar: {gsd_m: 1, pairs: {strategy: max, count: 1.5}}\n", "an integer", 1);
}

TEST(FlightConfigErrors, UnknownWord) {
  ExpectBad("body: FRU\n", "body: 'FRU' is not one of FRD, FLU", 1);
  ExpectBad("gnss: {robust: hubber}\n", "did you mean 'huber'", 1);
  ExpectBad("strips_crs: utm:61n\n", "'utm:61n' is not one of", 1);
  ExpectBad("lidar: {gsd_m: 1, pairs: {strategy: some}}\n", "all, max, freq, time_window", 1);
}

TEST(FlightConfigErrors, GnssProcesses) {
  const std::string begin = "gnss:\n  processes:\n    - {type: gauss_markov, ";
  ExpectBad(begin + "sigma_enu_m: [0, 0, 0], tau_s: 120}\n",
            "gnss.processes[0].sigma_enu_m: one element must be at least 1e-12", 3);
  ExpectBad(begin + "sigma_enu_m: [0.01, -0.01, 0.02], tau_s: 120}\n", "no element may be negative",
            3);
  ExpectBad(begin + "sigma_enu_m: 0.01, tau_s: 120}\n", "expected a list of 3 numbers", 3);
  ExpectBad(begin + "sigma_enu_m: [0.01, 0.01, 0.02], tau_s: 0}\n",
            "gnss.processes[0].tau_s: must be greater than 0", 3);
  ExpectBad(begin + "sigma_enu_m: [0.01, 0.01, 0.02]}\n", "gnss.processes[0].tau_s", 3);
  ExpectBad(begin + "tau_s: 120}\n", "gnss.processes[0].sigma_enu_m", 3);
  ExpectBad(begin + "sigma_enu: [0.01, 0.01, 0.02], tau_s: 120}\n", "did you mean 'sigma_enu_m'?",
            3);
  ExpectBad("gnss:\n  processes: [{type: random_walk, sigma_enu_m: [1, 1, 1], tau_s: 1}]\n",
            "gnss.processes[0].type: 'random_walk' is not one of gauss_markov", 2);
  ExpectBad(begin + "sigma_enu_m: [1, 1, 1], tau_s: 1, grows_with: bang}\n", "did you mean 'bank'?",
            3);
  ExpectBad("gnss: {processes: 3}\n", "gnss.processes: expected auto, or a list of processes", 1);
  ExpectBad("gnss: {processes: none}\n", "gnss.processes: expected auto, or a list", 1);
  ExpectBad("gnss: {processes: {tau_s: 1}}\n", "gnss.processes: expected a list", 1);
}

TEST(FlightConfigErrors, Strips) {
  ExpectBad("strips:\n  - {name: a, t0: 1, t1: 2}\n  - {name: a, t0: 3, t1: 4}\n",
            "strips[1].name: strip 'a' is given twice", 3);
  ExpectBad("strips: [{name: a, t0: 2, t1: 1}]\n", "strips[0].t1: must be later", 1);
  ExpectBad("strips: [{name: a, t0: 2}]\n", "strips[0].t1: expected a number", 1);
}

TEST(FlightConfigErrors, ImuWithoutGradeNeedsBothWhiteNoises) {
  ExpectBad("imu:\n  file: a\n", "imu.gyro: the white noise is missing", 2);
  ExpectBad("imu:\n  gyro: {white_deg_sqrt_h: 0.1}\n", "give white_m_s_sqrt_h", 2);
  ExpectBad("imu:\n  accel: {white_m_s_sqrt_h: 0.1}\n  gyro: {processes: []}\n",
            "imu.gyro.white_deg_sqrt_h: the white noise is missing", 3);
}

TEST(FlightConfigErrors, Vibration) {
  const auto bad = [](const std::string& item, const std::string& what) {
    ExpectBad("imu:\n  grade: ln200\n  vibration:\n    - " + item + "\n", what, 4);
  };
  bad("{sigma_gyro_deg_s: 0.1}", "imu.vibration[0].window_s: is missing");
  bad("{window_s: [2, 1], sigma_gyro_deg_s: 0.1}", "begin before end");
  bad("{window_s: [1, 2]}", "one must be positive");
  bad("{window_s: [1, 2], sigma_gyro_deg_s: -0.1}", "sigma_gyro_deg_s");
  bad("{window_s: [1, 2], sigma_accel_m_s2: -0.1}", "sigma_accel_m_s2");
  bad("{window_s: [1, 2], sigma_gyro_deg: 0.1}", "sigma_gyro_deg_s");
}

TEST(FlightConfigErrors, UnknownGrade) { ExpectBad("imu:\n  grade: ln100\n", "ln200", 2); }

TEST(FlightConfigErrors, ProcessesOfTheWrongKind) {
  const std::string head = "imu:\n  grade: ln200\n  gyro:\n    processes:\n      - ";
  ExpectBad(head + "{type: random_constant, sigma_mg: 1}\n", "did you mean 'sigma_deg_h'", 5);
  ExpectBad(head + "{type: gauss_markov, sigma_deg_h: 1}\n", "tau_s: expected a number", 5);
  ExpectBad(head + "{type: random_constant, sigma_deg_h: 1, tau_s: 3}\n", "unknown key 'tau_s'", 5);
  ExpectBad(head + "{type: random_walk, sigma_deg_h: 1}\n", "did you mean 'sigma_deg_h_sqrt_h'", 5);
  ExpectBad(head + "{type: markov, sigma_deg_h: 1}\n", "gauss_markov", 5);
  ExpectBad(head + "{type: random_constant}\n", "sigma_deg_h: expected a number, found nothing", 5);
}

TEST(FlightConfigErrors, LidarNeedsItsNoise) { ExpectBad("lidar: {}\n", "one of lidar.gsd_m", 1); }

TEST(FlightConfigErrors, MountingMatrixIsNoRotation) {
  ExpectBad("lidar:\n  gsd_m: 1\n  R_sensor_to_body: [[1, 0, 0], [0, 1, 0], [0, 0, 1.1]]\n",
            "lidar.R_sensor_to_body: matrix is not a rotation", 3);
  ExpectBad("lidar:\n  gsd_m: 1\n  R_sensor_to_body: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\n",
            "reflection", 3);
}

TEST(FlightConfigErrors, Georeferencing) {
  const std::string begin = "lidar: {gsd_m: 1, georeferenced_with: ";
  ExpectBad(begin + "declared}\n", "must be `boresight`", 1);
  ExpectBad(begin + "[1, 2, 3]}\n", "georeferenced_with", 1);
  ExpectBad(begin + "{}}\n", "georeferenced_with.boresight_deg", 1);
  ExpectBad(begin + "{boresight: [1, 2, 3]}}\n", "boresight_deg", 1);
  ExpectBad(begin + "{boresight_deg: [1, 2]}}\n", "boresight_deg", 1);
  ExpectBad(begin + "{boresight_deg: [1, 2, 181]}}\n", "within -180 and 180", 1);
}

TEST(FlightConfigErrors, ScanAxes) {
  ExpectBad("lidar: {gsd_m: 1, scan_axis: [1, 1, 0]}\n", "scan_axis: must be a unit vector", 1);
  ExpectBad("lidar: {gsd_m: 1, scan_axis: [0, 0, 1]}\n", "perpendicular to scan_axis", 1);
  ExpectBad("lidar: {gsd_m: 1, nadir_axis: [0, 0, -1]}\n", "below the horizon", 1);
  ExpectBad("{body: FLU, lidar: {gsd_m: 1}}\n", "below the horizon", 1);
}

TEST(FlightConfigErrors, SelectionWithoutItsParameter) {
  ExpectBad("lidar: {gsd_m: 1, pairs: {strategy: max}}\n", "count: is required by strategy max", 1);
  ExpectBad("lidar: {gsd_m: 1, pairs: {strategy: freq}}\n", "freq_hz: is required", 1);
  ExpectBad("lidar: {gsd_m: 1, pairs: {strategy: time_window}}\n", "window_s: is required", 1);
}

TEST(FlightConfigErrors, Estimate) {
  ExpectBad("estimate:\n  - boresight\n  - gyro_bias_process\n", "state it in the noise", 3);
  ExpectBad("estimate: [gnss_outage]\n", "a fault of the data and cannot be estimated", 1);
  ExpectBad("estimate: [boresight_step]\n", "'boresight_step' needs t0_s", 1);
  ExpectBad("estimate: [{unknown: boresight_step}]\n", "t0_s: is missing", 1);
  ExpectBad("estimate: [{unknown: gnss_position_step, window_s: [3, 2]}]\n", "begin before end", 1);
  ExpectBad("estimate: [{unknown: gravity_tilt, t0_s: 3}]\n", "does not belong to", 1);
  ExpectBad("estimate: [{unknown: boresight, t0_s: 3}]\n", "does not belong to", 1);
  ExpectBad("estimate: [{unknown: gravity_tilt, sigma: [1, 2, 3]}]\n", "one number or 2, in arcsec",
            1);
  ExpectBad("across: lidar_lever_arm\n", "'boresight' is missing", 1);
  ExpectBad("across: [boresight, lidar_lever_am]\n", "lidar_lever_arm", 1);
  ExpectBad("across: [boresight, boresight]\n", "given twice", 1);
  ExpectBad("across: [boresight, boresight_step]\n", "not a constant", 1);
  ExpectBad("across: [{unknown: boresight, random_walk_deg: -1}]\n", "random_walk_deg", 1);
  ExpectBad("unmodelled: all\n", "none", 1);
  ExpectBad("unmodelled: {gyro_misalinment: 1}\n", "gyro_misalignment", 1);
  ExpectBad("unmodelled:\n  gyro_misalignment: -1\n", "unmodelled.gyro_misalignment", 2);
  ExpectBad("unmodelled: {gravity_tilt: [1, 2, 3]}\n", "one number or 2, in arcsec", 1);
  ExpectBad("unmodelled: {gnss_position_step: 0.01}\n", "a part of the flight", 1);
  ExpectBad("unmodelled: {gnss_noise_scale: 2}\n", "gnss_noise_scale", 1);
  ExpectBad("estimate: [lidar_lever_am]\n", "did you mean 'lidar_lever_arm'?", 1);
  ExpectBad("estimate: [boresight, boresight]\n", "estimate[1]: 'boresight' is given twice", 1);
  ExpectBad("estimate: [{unknown: boresight, sigma: 1}]\n", "lidar.boresight_sigma_deg", 1);
  ExpectBad("estimate: [{unknown: gnss_lever_arm, sigma: 0}]\n", "greater than 0", 1);
  ExpectBad("estimate: [{sigma: 1}]\n", "estimate[0].unknown: expected a word", 1);
}

/// Returns whether the text is valid. Exceptions other than InvalidConfig are not caught.
bool Parses(const std::string& text) {
  try {
    ParseFlightConfig(text, "/f");
    return true;
  } catch (const InvalidConfig&) {
    return false;
  }
}

TEST(FlightConfigErrors, AxesAndOffsetsThatCannotBe) {
  ExpectBad("imu:\n  grade: airins\n  R_imu_to_body: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\n",
            "imu.R_imu_to_body", 3);
  ExpectBad("gnss:\n  time_offset_s: 5e9\n", "gnss.time_offset_s: must lie within", 2);
  ExpectBad("imu:\n  grade: airins\n  rate_unit: grad/s\n", "imu.rate_unit", 3);
  ExpectBad("imu:\n  grade: airins\n  rate_unit: -1e-10\n", "imu.rate_unit", 3);
  ExpectBad("imu:\n  grade: airins\n  force_unit: 0\n", "imu.force_unit", 3);
}

std::string Repeated(const std::string& item, int count) {
  std::string list = item;
  for (int i = 1; i < count; ++i) list += ", " + item;
  return "[" + list + "]";
}

TEST(FlightConfigErrors, ListsThatNobodyWritesByHand) {
  const std::string gyro = "{type: random_constant, sigma_deg_h: 1}";
  const std::string accel = "{type: random_constant, sigma_mg: 1}";
  const std::string gnss = "{type: gauss_markov, sigma_enu_m: [1, 1, 1], tau_s: 1}";
  const std::string processes = "    processes: ";
  ExpectBad("imu:\n  grade: ln200\n  gyro:\n" + processes + Repeated(gyro, 21) + "\n",
            "imu.gyro.processes: has 21 elements, at most 20", 4);
  ExpectBad("imu:\n  grade: ln200\n  accel:\n" + processes + Repeated(accel, 1000) + "\n",
            "imu.accel.processes: has 1000 elements, at most 20", 4);
  ExpectBad("gnss:\n  processes: " + Repeated(gnss, 21) + "\n", "at most 20", 2);
  ExpectBad("estimate: " + Repeated("boresight", 1001) + "\n", "at most 1000", 1);
  ExpectBad("strips: " + Repeated("{name: a, t0: 1, t1: 2}", 1001) + "\n", "at most 1000", 1);
  ExpectBad("lidar:\n  gsd_m: 1\n  p2p: " + Repeated("a", 10001) + "\n", "at most 10000", 3);
  ExpectBad("imu:\n  grade: ln200\n  vibration: " + Repeated("{}", 1001) + "\n", "at most 1000", 3);
}

TEST(FlightConfigErrors, DeepNestingIsRefused) {
  EXPECT_FALSE(Parses(std::string(100000, '[')));
  EXPECT_FALSE(Parses("name: " + std::string(100000, '{')));
}

TEST(FlightConfigErrors, AnAliasOfItselfIsRefused) {
  EXPECT_FALSE(Parses("strips: &a [*a]\n"));
  EXPECT_FALSE(Parses("gnss: &a {file: *a}\n"));
}

TEST(FlightConfigErrors, DamagedTextIsReadOrRefusedButNothingElse) {
  const std::string whole =
      "body: FLU\nstrips: [{name: a, t0: 1, t1: 2}]\nimu: {grade: ln200, gyro: {processes: [{type: "
      "random_walk, sigma_deg_h_sqrt_h: 0.1}]}}\nlidar:\n  gsd_m: 1e-1\n  p2p: [a, b]\n  "
      "R_sensor_to_body: [[1, 0, 0], [0, -1, 0], [0, 0, -1]]\nestimate: [boresight]\n";
  ASSERT_TRUE(Parses(whole));
  constexpr unsigned kSeed = 1;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(kSeed);
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string text = whole;
    text[random() % text.size()] = static_cast<char>(random() % 256);
    if (i % 3 == 0) text.resize(random() % text.size());
    EXPECT_NO_THROW(refused += Parses(text) ? 0 : 1) << text;
  }
  EXPECT_GT(refused, 1000);  // most of the changed documents are invalid
}

TEST(FlightConfigErrors, HostileValuesOfEveryKeyAreReadOrRefusedWithTheirPlace) {
  const TempFolder folder;
  std::ifstream model(std::filesystem::path(DN_REFERENCE_DIR) / "flight.yaml");
  const std::string text{std::istreambuf_iterator<char>(model), {}};
  ASSERT_FALSE(text.empty());
  const auto parse = [](const std::string& document) { ParseFlightConfig(document, "/f"); };
  ASSERT_NO_THROW(parse(text));
  const std::string more =
      "frame: {origin_deg_m: [46, 6, 400]}\ntime_span_s: [1, 2]\nstrips: [{name: a, t0: 1, t1: "
      "2}]\n"
      "imu: {max_gap_s: 0.1, grade: ln200}\nlidar: {sigma_p_m: 0.1, boresight_sigma_deg: [1, 1, 1],"
      " pairs: {strategy: freq, count: 3, freq_hz: 1, window_s: 2}, beams: {angles_deg: [-15, 15], "
      "angle_sigma_deg: 0.1, range_offset_sigma_m: 0.03}}\n"
      "estimate: [boresight, {unknown: gnss_lever_arm, sigma: 0.1}]\nnetwork: {node_rate_hz: 10}\n";
  ASSERT_NO_THROW(parse(more));
  EXPECT_GT(testing::CountRefused(text, parse), 1000);
  EXPECT_GT(testing::CountRefused(more, parse), 500);
}

TEST(FlightConfigErrors, AliasesAreNotExpanded) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before;
    for (int k = 0; k < 9; ++k) bomb.append(", ").append(before);
    bomb += "]\n";
  }
  EXPECT_FALSE(Parses(bomb));
  EXPECT_FALSE(Parses("lidar: {gsd_m: 1, p2p: [" + std::string("[[[[a]]]]") + "]}\n"));
}

TEST(FlightConfigErrors, AFileOfAbsurdSizeIsRefused) {
  const TempFolder folder;
  folder.Write("flight.yaml", std::string(2000000, '#'));
  ExpectInvalid([&] { ReadFlightConfig(folder.path()); }, "at most 1048576 are read", 0);
}

TEST(FlightConfigErrors, NamesWithControlCharacters) {
  const std::string what = "contains a line break or another control character";
  ExpectBad("body: FRD\nname: \"a\\n!b\"\n", "name: " + what, 2);
  ExpectBad("name: \"a\\e[2J\"\n", "name: " + what, 1);
  ExpectBad("strips: [{name: \"a\\rb\", t0: 1, t1: 2}]\n", "strips[0].name: " + what, 1);
}

}  // namespace dn::files_test
