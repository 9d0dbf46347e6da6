#include <dn/report/json.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <random>

#include "flight_of_numbers.h"

namespace dn::testing::apps_test {

using ::testing::AnyOf;
using ::testing::Each;
using ::testing::Le;
namespace fs = std::filesystem;

// The simulated boresight, `boresight_deg` of mistakes.yaml.
constexpr double kTruthDeg[] = {0.2, 0.03, 0.35};
// Largest error of each angle, in its own sigmas. One of three angles exceeds it by chance once in
// 5000 flights.
constexpr double kLargestError = 4.0;
// A result with a larger sigma does not count as calibrated.
constexpr double kLargestSigmaDeg = 2.0;
constexpr double kFoot = 0.3048;

/// Returns a flight simulated from mistakes.yaml with one text replaced. Each flight is simulated
/// once per process.
const fs::path& Simulated(const std::string& old_text = "", const std::string& new_text = "",
                          int seed = 1) {
  static std::map<std::string, std::unique_ptr<TempFolder>> folders;
  static std::map<std::string, fs::path> flights;
  const std::string key = fmt::format("{}/{}", seed, new_text);
  if (flights.count(key) > 0) return flights[key];
  std::string scenario = FileContent(DN_MISTAKES_SCENARIO);
  if (!old_text.empty()) scenario.replace(scenario.find(old_text), old_text.size(), new_text);
  folders[key] = std::make_unique<TempFolder>();
  folders[key]->Write("scenario.yaml", scenario);
  const fs::path& work = folders[key]->path();
  const ProgramRun run = RunProgram({"simulate", (work / "scenario.yaml").string(), "--seed",
                                     std::to_string(seed), "--out", (work / "flight").string()});
  if (run.exit_code != 0) throw std::runtime_error(run.err);
  return flights[key] = work / "flight";
}

enum class Must {
  kNotDeceive,      // rejected, contradicted, or calibrated correctly
  kBeRight,         // calibrated correctly
  kBeContradicted,  // rejected or contradicted
  kNotBeObservable
};

struct Mistake {
  const char* name;
  std::function<void(const FlightOfNumbers&)> make;
  Must must = Must::kNotDeceive;
};

void PrintTo(const Mistake& mistake, std::ostream* stream) { *stream << mistake.name; }

std::function<void(const FlightOfNumbers&)> Late(double seconds) {
  return [=](const FlightOfNumbers& flight) {
    flight.EachPair([=](std::vector<double>& pair) {
      pair[0] += seconds;
      pair[1] += seconds;
    });
  };
}

std::function<void(const FlightOfNumbers&)> Set(const std::string& key, const std::string& value) {
  return [=](const FlightOfNumbers& flight) { flight.Set(key, value); };
}

/// Replaces the range r of each laser vector by scale * r + offset.
std::function<void(const FlightOfNumbers&)> Ranges(double scale, double offset_m) {
  return [=](const FlightOfNumbers& flight) {
    flight.EachPair([=](std::vector<double>& pair) {
      for (const int first : {2, 5}) {
        const double range = std::hypot(pair[first], pair[first + 1], pair[first + 2]);
        for (int i = first; i < first + 3; ++i) pair[i] *= scale + offset_m / range;
      }
    });
  };
}

/// Shifts a share of the pairs by 0.5 to 5 m in a random direction.
std::function<void(const FlightOfNumbers&)> WrongPairs(double share) {
  return [=](const FlightOfNumbers& flight) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::normal_distribution<double> normal;
    flight.EachPair([&](std::vector<double>& pair) {
      if (uniform(random) > share) return;
      const double v[] = {normal(random), normal(random), normal(random)};
      const double scale = (0.5 + 4.5 * uniform(random)) / std::hypot(v[0], v[1], v[2]);
      for (int i = 0; i < 3; ++i) pair[2 + i] += v[i] * scale;
    });
  };
}

/// Permutes the given columns of the pairs, so that they belong to other pairs.
void ShufflePairs(const FlightOfNumbers& flight, const std::vector<int>& columns) {
  for (const std::string& name : flight.PairFiles()) {
    const Table rows = flight.Rows(name);
    std::vector<std::size_t> order(rows.size());
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), std::mt19937(1));
    Table shuffled = rows;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (const int column : columns) shuffled[i][column] = rows[order[i]][column];
    }
    flight.WriteRows(name, shuffled);
  }
}

void SwapEpochs(const FlightOfNumbers& flight) {
  flight.EachPair([](std::vector<double>& pair) { std::swap(pair[0], pair[1]); });
}

void RepeatPairs(const FlightOfNumbers& flight) {
  for (const std::string& name : flight.PairFiles()) {
    Table repeated;
    for (const std::vector<double>& row : flight.Rows(name))
      repeated.insert(repeated.end(), 25, row);
    flight.WriteRows(name, repeated);
  }
}

void KeepThreePairs(const FlightOfNumbers& flight) {
  const std::vector<std::string> names = flight.PairFiles();
  Table rows = flight.Rows(names.front());
  rows.resize(3);
  flight.WriteRows(names.front(), rows);
  flight.Set("lidar.p2p", "[" + names.front() + "]");
}

void GnssOutliers(const FlightOfNumbers& flight) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  flight.EachRow("GPS.txt", [&](std::vector<double>& row) {
    if (std::abs(uniform(random)) > 0.05) return;
    row[1] += 1e-4 * uniform(random);
    row[2] += 1e-4 * uniform(random);
    row[3] += 10.0 * uniform(random);
  });
}

void GnssSigmasATenth(const FlightOfNumbers& flight) {
  flight.EachRow("GPS.txt", [](std::vector<double>& row) {
    for (int i = 4; i < 7; ++i) row[i] *= 0.1;
  });
}

/// Converts all body quantities to forward-left-up without declaring it in flight.yaml.
void UndeclaredAxes(const FlightOfNumbers& flight) {
  flight.EachRow("IMU.txt", [](std::vector<double>& row) {
    for (const int i : {2, 3, 5, 6}) row[i] = -row[i];
  });
}

void ConvertAllAxesUndeclared(const FlightOfNumbers& flight) {
  UndeclaredAxes(flight);
  flight.Set("gnss.lever_arm_m", "[0.4, 0.1, 1.1]");
  flight.Set("lidar.lever_arm_m", "[0.14, 0.02, -0.21]");
  flight.Set("lidar.R_sensor_to_body", "[[0, 1, 0], [0, 0, -1], [-1, 0, 0]]");
}

void UndeclaredAxesAndNadir(const FlightOfNumbers& flight) {
  ConvertAllAxesUndeclared(flight);
  flight.Set("lidar.nadir_axis", "[-1, 0, 0]");
}

void DeclaredAsLn200(const FlightOfNumbers& flight) {
  flight.Take(Simulated("preset: airins",
                        "preset: apx15, accel: {processes: [{type: random_constant, sigma_mg: 3}, "
                        "{type: gauss_markov, sigma_mg: 2, tau_s: 60}]}"),
              {"flight.yaml", "IMU.txt", "GPS.txt", "lidar"});
  std::string yaml = flight.Read("flight.yaml");
  const std::size_t begin = yaml.find("  grade:");
  yaml.replace(begin, yaml.find("gnss:") - begin, "  grade: ln200\n");
  flight.Write("flight.yaml", yaml);
}

void GyroScale(const FlightOfNumbers& flight) {
  flight.Take(Simulated("pairs: {count: 1500}",
                        "pairs: {count: 1500}\neffects: [{effect: gyro_scale_factor, "
                        "value: [1000, 1000, 1000]}]"),
              {"IMU.txt", "GPS.txt", "lidar"});
}

void TakeForeignPairs(const FlightOfNumbers& flight) {
  flight.Take(Simulated("[-700, 0, 700, 0, 700, 45]", "[-700, 60, 700, 60, 700, 45]", 2),
              {"lidar"});
}

class Mistakes : public ::testing::TestWithParam<Mistake> {
 protected:
  /// Result of the program with the largest error in sigmas.
  struct Answer {
    ProgramRun run;
    std::string verdict = "refused";
    double error = 0.0;
    double sigma_deg = 0.0;
    double sigma0 = 0.0;
  };

  static Answer Ask(const FlightOfNumbers& flight) {
    Answer answer{flight.Run("calibrate")};
    if (!fs::exists(flight.out() / "result.json")) return answer;
    const Json result = Json::parse(FileContent(flight.out() / "result.json"));
    answer.verdict = result["assessment"]["verdict"];
    answer.sigma0 = result["adjustment"]["sigma0"];
    for (int i = 0; i < 3; ++i) {
      const double sigma_deg = result["boresight"]["sigma_deg"][i];
      const double angle_deg = result["boresight"]["angles_deg"][i];
      answer.sigma_deg = std::max(answer.sigma_deg, sigma_deg);
      answer.error = std::max(answer.error, std::abs(angle_deg - kTruthDeg[i]) / sigma_deg);
    }
    return answer;
  }

  static std::string Describe(const Answer& answer) {
    return fmt::format("exit {}, {}, {:.1f} sigmas off, sigma {:.2g} deg, sigma0 {:.3g}\n{}",
                       answer.run.exit_code, answer.verdict, answer.error, answer.sigma_deg,
                       answer.sigma0, answer.run.err);
  }
};

bool SaysCalibrated(const std::string& verdict) {
  return verdict == "calibrated" || verdict == "absorbed";
}

TEST_P(Mistakes, NeverPassForACalibration) {
  const FlightOfNumbers flight(Simulated());
  GetParam().make(flight);
  const Answer answer = Ask(flight);
  SCOPED_TRACE(Describe(answer));
  if (SaysCalibrated(answer.verdict)) {
    EXPECT_EQ(answer.run.exit_code, 0);
    EXPECT_LE(answer.error, kLargestError);
    EXPECT_LE(answer.sigma_deg, kLargestSigmaDeg);
  } else {
    EXPECT_THAT(answer.run.exit_code, AnyOf(1, 2));
    EXPECT_NE(answer.run.err.find("dn calibrate: error: "), std::string::npos);
  }
  switch (GetParam().must) {
    case Must::kNotDeceive:
      break;
    case Must::kBeRight:
      EXPECT_EQ(answer.verdict, "calibrated");
      break;
    case Must::kBeContradicted:
      EXPECT_FALSE(SaysCalibrated(answer.verdict));
      break;
    case Must::kNotBeObservable:
      EXPECT_EQ(answer.verdict, "not_observable");
      break;
  }
}

const Mistake kMistakes[] = {
    {"PairsLateBy1s", Late(1.0), Must::kBeContradicted},
    {"PairsLateBy10ms", Late(0.01), Must::kBeContradicted},
    {"PairsLateBy2ms", Late(0.002), Must::kBeContradicted},
    {"LidarLeverArmMirrored", Set("lidar.lever_arm_m", "[-0.14, 0.02, -0.21]"),
     Must::kBeContradicted},
    {"LidarLeverArmOmitted", Set("lidar.lever_arm_m", "[0, 0, 0]")},
    {"LidarLeverArmInMillimetres", Set("lidar.lever_arm_m", "[140, -20, 210]"),
     Must::kBeContradicted},
    {"EpochsOfPairsSwapped", SwapEpochs, Must::kBeContradicted},
    {"PairsOfAnotherFlight", TakeForeignPairs, Must::kBeContradicted},
    {"PairsShuffled",
     [](const FlightOfNumbers& f) {
       ShufflePairs(f, {1, 5, 6, 7});
     },
     Must::kBeContradicted},
    {"VectorsOfPairsShuffled",
     [](const FlightOfNumbers& f) {
       ShufflePairs(f, {5, 6, 7});
     },
     Must::kBeContradicted},
    {"VectorsInFeet", Ranges(1.0 / kFoot, 0.0), Must::kBeContradicted},
    {"StartTurnedBy90DegInRoll", Set("lidar.boresight_deg", "[90, 0, 0]")},
    {"StartTurnedBy90DegInPitch", Set("lidar.boresight_deg", "[0, 90, 0]")},
    {"StartTurnedBy90DegInYaw", Set("lidar.boresight_deg", "[0, 0, 90]")},
    {"PriorThatContradicts", Set("lidar.boresight_sigma_deg", "0.001"), Must::kBeContradicted},
    {"MostPairsWrong", WrongPairs(0.6)},
    {"RangeOffsetOfHalfAMetre", Ranges(1.0, 0.5)},
    {"RangeScaleOfOnePerMille", Ranges(1.001, 0.0)},
    {"Apx15DeclaredAsLn200", DeclaredAsLn200},
    {"GyroScaleOf1000ppm", GyroScale},
    {"GnssSigmasATenth", GnssSigmasATenth, Must::kBeContradicted},
    {"InertialAxesUndeclared", UndeclaredAxes, Must::kBeContradicted},
    {"BodyAxesUndeclared", ConvertAllAxesUndeclared, Must::kBeContradicted},
    {"BodyAxesUndeclaredAndNadirTurned", UndeclaredAxesAndNadir, Must::kBeContradicted},
    {"AxesDeclaredThatAreNot", Set("body", "FLU"), Must::kBeContradicted},
    {"ThreePairs", KeepThreePairs, Must::kNotBeObservable},
    {"PairsTooCoarseToTell", Set("lidar.sigma_p_m", "1000"), Must::kNotBeObservable},
};

const Mistake kNoMistakes[] = {
    {"NoFault", [](const FlightOfNumbers&) {}, Must::kBeRight},
    {"StartTurnedBy5Deg", Set("lidar.boresight_deg", "[5, -5, 5]"), Must::kBeRight},
    {"AFifthOfThePairsWrong", WrongPairs(0.2), Must::kBeRight},
    {"FivePercentOfGnssWrong", GnssOutliers, Must::kBeRight},
};

std::string MistakeName(const ::testing::TestParamInfo<Mistake>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(PeopleManyRuns, Mistakes, ::testing::ValuesIn(kMistakes), MistakeName);
INSTANTIATE_TEST_SUITE_P(NobodyManyRuns, Mistakes, ::testing::ValuesIn(kNoMistakes), MistakeName);

// Pairs that are listed more than once must not reduce the sigmas.
TEST(RepeatedPairsManyRuns, NarrowNoSigma) {
  const FlightOfNumbers once(Simulated());
  const FlightOfNumbers repeated(Simulated());
  RepeatPairs(repeated);
  ASSERT_EQ(once.Run("calibrate").exit_code, 0);
  const ProgramRun run = repeated.Run("calibrate");
  if (run.exit_code != 0) {  // rejected
    EXPECT_NE(run.err.find("dn calibrate: error: "), std::string::npos) << run.err;
    return;
  }
  const Json expected = Json::parse(FileContent(once.out() / "result.json"))["boresight"];
  const Json actual = Json::parse(FileContent(repeated.out() / "result.json"))["boresight"];
  for (int i = 0; i < 3; ++i) {
    const double sigma_deg = expected["sigma_deg"][i];
    EXPECT_NEAR(actual["sigma_deg"][i].get<double>(), sigma_deg, 1e-6 * sigma_deg);
  }
}

}  // namespace dn::testing::apps_test
