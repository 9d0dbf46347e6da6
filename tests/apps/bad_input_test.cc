#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <sstream>

#include "damaged_flight.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
namespace fs = std::filesystem;

/// Expects a failed run: the exit code, one line on stderr that contains `what`, and report.json
/// with the same message as the only result.
void ExpectFailure(const ProgramRun& run, const DamagedFlight& flight, int exit_code,
                   const std::string& kind, const std::string& what) {
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  const std::size_t at = run.err.find(": error: ");
  ASSERT_NE(at, std::string::npos) << run.err;
  const std::string message = run.err.substr(at + 9);
  EXPECT_THAT(message, HasSubstr(what));
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 1) << message;
  EXPECT_EQ(NamesIn(flight.out()), std::vector<std::string>{"report.json"});
  const Json error = Json::parse(FileContent(flight.out() / "report.json"))["error"];
  EXPECT_EQ(error["kind"], kind);
  EXPECT_EQ(error["message"].get<std::string>() + "\n", message);
}

TEST(CliBadInput, MissingFolder) {
  const DamagedFlight flight;
  fs::remove_all(flight.path());
  ExpectFailure(flight.Run("calibrate"), flight, 2, "configuration", flight.path().string());
}

TEST(CliBadInput, MissingFlightYaml) {
  const DamagedFlight flight;
  fs::remove(flight.path() / "flight.yaml");
  ExpectFailure(flight.Run("smooth"), flight, 2, "configuration", "flight.yaml");
}

TEST(CliBadInput, MissingSection) {
  const DamagedFlight flight;
  flight.Write("flight.yaml", "name: x\ngnss: {file: GPS.txt}\n");
  ExpectFailure(flight.Run("calibrate"), flight, 2, "configuration", "'imu'");
}

TEST(CliBadInput, MissingDataFile) {
  const DamagedFlight flight;
  fs::remove(flight.path() / "IMU.txt");
  ExpectFailure(flight.Run("calibrate"), flight, 1, "input",
                "IMU.txt does not exist; the key imu.file");
}

TEST(CliBadInput, MissingPairs) {
  const DamagedFlight flight;
  fs::remove_all(flight.path() / "lidar");
  ExpectFailure(flight.Run("calibrate"), flight, 1, "input", "lidar.p2p");
}

TEST(CliBadInput, UnknownKeyNamesTheNearest) {
  const DamagedFlight flight;
  flight.Replace("flight.yaml", "boresight_deg:", "boresigt_deg:");
  ExpectFailure(flight.Run("calibrate"), flight, 2, "configuration",
                "unknown key 'boresigt_deg'; did you mean 'boresight_deg'");
}

TEST(CliBadInput, TextThatIsNotYaml) {
  const DamagedFlight flight;
  flight.Write("flight.yaml", "name: [x\n");
  ExpectFailure(flight.Run("calibrate"), flight, 2, "configuration", "flight.yaml:");
}

TEST(CliBadInput, WrongNumberOfColumns) {
  const DamagedFlight flight;
  flight.ReplaceLine("IMU.txt", 7, "381000.14, 0, 0, 0, 0, 0");
  ExpectFailure(flight.Run("calibrate"), flight, 1, "input", "IMU.txt:7");
}

TEST(CliBadInput, NotANumber) {
  const DamagedFlight flight;
  flight.ReplaceLine("GPS.txt", 12, "381011, nan, 6.5, 400, 0.01, 0.01, 0.02");
  ExpectFailure(flight.Run("smooth"), flight, 1, "input", "GPS.txt:12");
}

TEST(CliBadInput, TimeStepsBack) {
  const DamagedFlight flight;
  flight.ReplaceLine("GPS.txt", 30, "381000.5, 46.57, 6.52, 600, 0.01, 0.01, 0.02");
  ExpectFailure(flight.Run("smooth"), flight, 1, "input", "GPS.txt:30");
}

TEST(CliBadInput, NoOverlapOfImuAndGnss) {
  const DamagedFlight flight;
  flight.Write(
      "GPS.txt",
      "1000, 46.57, 6.52, 600, 0.01, 0.01, 0.02\n1001, 46.57, 6.52, 600, 0.01, 0.01, 0.02\n");
  const ProgramRun run = flight.Run("calibrate");
  ExpectFailure(run, flight, 1, "input", "no GNSS epoch lies inside");
  EXPECT_THAT(run.err, HasSubstr("1000"));
  EXPECT_THAT(run.err, HasSubstr("381000"));
}

TEST(CliBadInput, PairOutsideTheInertialData) {
  const DamagedFlight flight;
  const std::string pairs = "lidar/" + NamesIn(flight.path() / "lidar").front();
  flight.ReplaceLine(pairs, 3, "381205, 390000, 100, 0, 0, 100, 0, 0");
  const ProgramRun run = flight.Run("calibrate");
  ExpectFailure(run, flight, 1, "input", pairs + ":3");
  EXPECT_THAT(run.err, HasSubstr("390000"));
}

TEST(CliBadInput, DamagedReferenceNamesTheRecord) {
  const DamagedFlight flight;
  flight.Write("reference.out", flight.Read("reference.out").substr(0, 1000));
  ExpectFailure(flight.Run("smooth"), flight, 1, "input", "reference.out");
}

TEST(CliBadInput, EmptyFiles) {
  for (const char* name : {"IMU.txt", "GPS.txt"}) {
    const DamagedFlight flight;
    flight.Write(name, "");
    ExpectFailure(flight.Run("calibrate"), flight, 1, "input", name);
  }
}

TEST(CliBadInput, TooFewGnssEpochsToStart) {
  const DamagedFlight flight;
  const std::string gps = flight.Read("GPS.txt");
  flight.Write("GPS.txt", gps.substr(0, gps.find('\n') + 1));
  const ProgramRun run = flight.Run("calibrate");
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_THAT(run.err, HasSubstr("error: "));
  EXPECT_EQ(NamesIn(flight.out()), std::vector<std::string>{"report.json"});
}

TEST(CliBadInput, PairsThatCannotBelongToThisFlight) {
  const DamagedFlight flight;
  const std::string pairs = "lidar/" + NamesIn(flight.path() / "lidar").front();
  std::string text;
  for (int i = 0; i < 50; ++i) {
    text += std::to_string(381200 + 0.3 * i) + ", " + std::to_string(381295 + 0.3 * i) +
            ", 200, 0, " + std::to_string(7 * i % 40) + ", -50, " + std::to_string(11 * i % 60) +
            ", 100\n";
  }
  flight.Write(pairs, text);
  const ProgramRun run = flight.Run("calibrate");
  const std::vector<std::string> names = NamesIn(flight.out());
  if (std::find(names.begin(), names.end(), "result.json") == names.end()) {
    EXPECT_EQ(run.exit_code, 1) << run.err;
    return;
  }
  const Json result = Json::parse(FileContent(flight.out() / "result.json"));
  EXPECT_NE(result["assessment"]["verdict"], "calibrated");
  EXPECT_EQ(run.exit_code, result["assessment"]["verdict"] == "not_observable" ? 1 : 0);
}

/// A file with one replaced row, and the expected message with its location.
struct BadRow {
  const char* name;
  const char* file;
  int line;
  const char* row;
  const char* what;
};

class CliBadRow : public ::testing::TestWithParam<BadRow> {};

TEST_P(CliBadRow, IsRefusedWithItsPlace) {
  const BadRow& bad = GetParam();
  const DamagedFlight flight;
  flight.ReplaceLine(bad.file, bad.line, bad.row);
  const ProgramRun run = flight.Run("calibrate");
  ExpectFailure(run, flight, 1, "input", std::string(bad.file) + ":" + std::to_string(bad.line));
  EXPECT_THAT(run.err, HasSubstr(bad.what));
}

INSTANTIATE_TEST_SUITE_P(
    Matrix, CliBadRow,
    ::testing::Values(
        BadRow{"ZeroSigma", "GPS.txt", 9, "381008, 46.57, 6.52, 600, 0, 0.01, 0.02", "sigma"},
        BadRow{"InfiniteSigma", "GPS.txt", 9, "381008, 46.57, 6.52, 600, inf, 0.01, 0.02", "inf"},
        BadRow{"NegativeSigma", "GPS.txt", 9, "381008, 46.57, 6.52, 600, -1, 0.01, 0.02", "sigma"},
        BadRow{"LatitudeBeyondThePole", "GPS.txt", 9, "381008, 96.57, 6.52, 600, 1, 1, 1", "lat"},
        BadRow{"NanRate", "IMU.txt", 9, "381000.18, nan, 0, 0, 0, 0, -9.8", "nan"},
        BadRow{"ImuStepsBack", "IMU.txt", 900, "381000.02, 0, 0, 0, 0, 0, -9.8", "time"},
        BadRow{"WordForANumber", "IMU.txt", 9, "381000.18, a, 0, 0, 0, 0, -9.8", "a"}),
    [](const auto& parameter) { return std::string(parameter.param.name); });

/// Returns the table with columns multiplied by `factor`.
std::string WithColumns(const std::string& table, std::size_t first, std::size_t last,
                        double factor) {
  std::istringstream in(table);
  std::string out;
  for (std::string line; std::getline(in, line);) {
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t column = 0; std::getline(cells, cell, ','); ++column) {
      const bool changed = column >= first && column <= last;
      out += (column > 0 ? "," : "") + (changed ? std::to_string(factor * std::stod(cell)) : cell);
    }
    out += "\n";
  }
  return out;
}

/// Returns the table without the lost lines. Line numbers start at 1.
std::string WithoutRows(const std::string& table, const std::function<bool(int)>& lost) {
  std::istringstream in(table);
  std::string out;
  int line = 0;
  for (std::string row; std::getline(in, row);) {
    if (!lost(++line)) out += row + "\n";
  }
  return out;
}

/// Returns the line of IMU.txt whose interval contains the first epoch of the first pair.
int FindPairLine(const DamagedFlight& flight) {
  const std::string pairs = flight.Read("lidar/" + NamesIn(flight.path() / "lidar").front());
  const double pair_s = std::stod(pairs);
  std::istringstream in(flight.Read("IMU.txt"));
  int line = 1;
  for (std::string row; std::getline(in, row); ++line) {
    if (std::stod(row) >= pair_s) return line;
  }
  return line;
}

TEST(CliBadInput, ALostImuRowAtAPairIsBridged) {
  const DamagedFlight flight;
  const int lost = FindPairLine(flight);
  flight.Write("IMU.txt", WithoutRows(flight.Read("IMU.txt"), [&](int k) { return k == lost; }));
  const ProgramRun run = flight.Run("calibrate");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json counts = Json::parse(FileContent(flight.out() / "report.json"))["counts"];
  EXPECT_EQ(counts["imu holes bridged"], 1);
  EXPECT_EQ(counts["pairs in IMU gaps"], 0);
}

TEST(CliBadInput, PairsInAHoleOfTheImuDataAreLeftOutAndCounted) {
  const DamagedFlight flight;
  const int lost = FindPairLine(flight);
  flight.Write("IMU.txt", WithoutRows(flight.Read("IMU.txt"),
                                      [&](int k) { return k > lost - 10 && k < lost + 10; }));
  const ProgramRun run = flight.Run("calibrate");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json counts = Json::parse(FileContent(flight.out() / "report.json"))["counts"];
  EXPECT_EQ(counts["imu gaps"], 1);
  EXPECT_GE(counts["pairs in IMU gaps"], 1);
}

TEST(CliBadInput, PairsListedManyTimesDoNotShrinkTheSigma) {
  const auto sigma_deg = [](const DamagedFlight& flight) {
    const ProgramRun run = flight.Run("calibrate");
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return Json::parse(FileContent(flight.out() / "result.json"))["boresight"]["sigma_deg"];
  };
  const DamagedFlight once, often;
  for (const std::string& name : NamesIn(often.path() / "lidar")) {
    const std::string rows = often.Read("lidar/" + name);
    for (int i = 0; i < 5; ++i) often.Write("lidar/again" + std::to_string(i) + name, rows);
  }
  std::string yaml = often.Read("flight.yaml");
  const std::size_t at = yaml.find("p2p:");
  yaml.replace(at, yaml.find('\n', at) - at, "p2p: [lidar/*.txt, ./lidar/*.txt]");
  often.Write("flight.yaml", yaml);
  EXPECT_EQ(sigma_deg(often), sigma_deg(once));
  const Json counts = Json::parse(FileContent(often.out() / "report.json"))["counts"];
  EXPECT_EQ(counts["repeated pairs"], 11 * counts["pairs"].get<long>());
}

TEST(CliBadInput, ANamedPipeForAFile) {
  for (const char* name : {"IMU.txt", "GPS.txt", "reference.out"}) {
    const DamagedFlight flight;
    fs::remove(flight.path() / name);
    ASSERT_EQ(mkfifo((flight.path() / name).c_str(), 0600), 0);
    ExpectFailure(flight.Run("calibrate"), flight, 1, "input", "this is a named pipe");
  }
  const DamagedFlight flight;
  fs::remove(flight.path() / "flight.yaml");
  ASSERT_EQ(mkfifo((flight.path() / "flight.yaml").c_str(), 0600), 0);
  ExpectFailure(flight.Run("calibrate"), flight, 2, "configuration", "this is a named pipe");
}

TEST(CliBadInput, ANamedPipeForWhatBelongsToATrajectory) {
  for (const char* name : {"trajectory.out", "trajectory_sigma.txt", "trajectory_covariance.txt"}) {
    const DamagedFlight flight;
    fs::copy(SmoothResult() / "trajectory.out", flight.path());
    fs::remove(flight.path() / name);
    ASSERT_EQ(mkfifo((flight.path() / name).c_str(), 0600), 0);
    const ProgramRun run = flight.Run("calibrate", {"--method", "gh"});
    ExpectFailure(run, flight, 1, "input", "this is a named pipe");
    EXPECT_THAT(run.err, HasSubstr(name));
  }
  const DamagedFlight flight;
  const fs::path pipe = flight.path() / "given.out";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  ExpectFailure(flight.Run("calibrate", {"--method", "gh", "--trajectory", pipe}), flight, 1,
                "input", "this is a named pipe");
}

TEST(CliBadInput, AScenarioThatIsADevice) {
  const DamagedFlight flight;
  const ProgramRun run = RunProgram({"simulate", "/dev/zero", "--out", flight.out().string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("this is a device, not a regular file"));
}

TEST(CliBadInput, AFileInMillisecondsIsNamed) {
  for (const char* name : {"IMU.txt", "GPS.txt"}) {
    const DamagedFlight flight;
    flight.Write(name, WithColumns(flight.Read(name), 0, 0, 1000.0));
    const ProgramRun run = flight.Run("calibrate");
    ExpectFailure(run, flight, 1, "input", name);
    EXPECT_THAT(run.err, HasSubstr("is it in milliseconds? Divide it by 1000"));
  }
}

TEST(CliBadInput, SpecificForceInG) {
  const DamagedFlight flight;
  flight.Write("IMU.txt", WithColumns(flight.Read("IMU.txt"), 4, 6, 1.0 / 9.80665));
  ExpectFailure(flight.Run("calibrate"), flight, 1, "input", "is it in g? Multiply by 9.80665");
}

TEST(CliBadInput, RatesInDegreesPerSecond) {
  const DamagedFlight flight;
  flight.Write("IMU.txt", WithColumns(flight.Read("IMU.txt"), 1, 3, 57.29577951308232));
  ExpectFailure(flight.Run("calibrate"), flight, 1, "input", "deg/s");
}

TEST(CliBadInput, NoPairsInTheFile) {
  const DamagedFlight flight;
  for (const std::string& name : NamesIn(flight.path() / "lidar")) {
    flight.Write("lidar/" + name, "# t_i, t_j, u_i, u_j\n");
  }
  ExpectFailure(flight.Run("calibrate"), flight, 1, "input", "lidar/");
}

TEST(CliBadInput, AllPairsOnOnePairOfEpochs) {
  const DamagedFlight flight;
  const std::string pairs = "lidar/" + NamesIn(flight.path() / "lidar").front();
  const std::string first = flight.Read(pairs).substr(0, flight.Read(pairs).find('\n') + 1);
  std::string text;
  for (int i = 0; i < 50; ++i) text += first;
  flight.Write(pairs, text);
  const ProgramRun run = flight.Run("calibrate");
  EXPECT_EQ(run.exit_code, 1) << run.out;
  EXPECT_THAT(run.err, HasSubstr("the same two epochs"));
}

TEST(CliBadInput, AQuaternionOfZeroNorm) {
  const DamagedFlight flight;
  flight.Write("initial_guess.txt",
               "381000, 46.57, 6.52, 600, 1, 0, 0, 0\n381400, 46.57, 6.52, 600, 0, 0, 0, 0\n");
  ExpectFailure(flight.Run("smooth"), flight, 1, "input", "initial_guess.txt:2");
}

TEST(CliBadInput, ATruncatedTrajectory) {
  const DamagedFlight flight;
  flight.Write("trajectory.out", flight.Read("reference.out").substr(0, 136 * 50 + 77));
  const ProgramRun run = flight.Run("calibrate", {"--method", "gh"});
  ExpectFailure(run, flight, 1, "input", "trajectory.out");
  EXPECT_THAT(run.err, HasSubstr("136"));
}

TEST(CliBadInput, CheckReportsGapsAndJitter) {
  const DamagedFlight flight;
  std::istringstream in(flight.Read("IMU.txt"));
  std::string text;
  int line = 0;
  for (std::string row; std::getline(in, row);) {
    if (++line >= 1000 && line < 1050) continue;  // one second
    if (line == 2000) {
      const std::size_t comma = row.find(',');
      row = std::to_string(std::stod(row.substr(0, comma)) + 0.004) + row.substr(comma);
    }
    text += row + "\n";
  }
  flight.Write("IMU.txt", text);
  const ProgramRun run = RunProgram({"check", flight.path().string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("1 gap"));
  EXPECT_THAT(run.out, HasSubstr("jitter"));
}

TEST(CliBadInput, CheckRefusesWhatCalibrateWould) {
  const DamagedFlight flight;
  flight.ReplaceLine("IMU.txt", 7, "381000.14, 0, 0, 0, 0, 0");
  const ProgramRun run = RunProgram({"check", flight.path().string()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, StartsWith("dn check: error: "));
  EXPECT_THAT(run.err, HasSubstr("IMU.txt:7"));
}

TEST(CliBadInput, CheckSaysWhatIsMissing) {
  const DamagedFlight flight;
  fs::remove_all(flight.path() / "lidar");
  const ProgramRun run = RunProgram({"check", flight.path().string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("dn smooth                 possible"));
  EXPECT_THAT(run.out, HasSubstr("dn calibrate --method dn  missing: pairs"));
}

}  // namespace dn::testing::apps_test
