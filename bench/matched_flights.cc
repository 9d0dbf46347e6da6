/// matched_flights: simulates point clouds of a scenario with several seeds. It matches and adjusts
/// each flight from its strips alone (`dn calibrate --method all`). The results are compared with
/// the truth: the pairs with the true positions of both points, and each method's boresight with
/// its covariance. With --draw-unmodelled, each flight has every effect that the model leaves out,
/// drawn from its prior. The errors of the pairs then contain those effects.
#include <dn/files/flight.h>
#include <dn/files/truth.h>
#include <dn/lidar/mounting.h>
#include <dn/report/json_reader.h>
#include <dn/rotation.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "child_process.h"

namespace dn::bench {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

// 99.9 % quantile of chi-square with three degrees of freedom.
constexpr double kChiSquare3Of999 = 16.27;
const std::vector<std::string> kMethods{"dn", "gh", "planes"};

struct Options {
  fs::path program = DN_PROGRAM;
  fs::path work;
  fs::path json;
  std::string scenario;
  std::vector<std::string> settings;
  int flights = 20;
  int first_seed = 1;
  int threads = 1;
  double unmodelled = 0.0;  ///< factor of the drawn effects; 0: none
  bool keep = false;
  double timeout_s = 3600.0;
};

Json ReadJson(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return ParseJson(text.str(), file.string());
}

apps::ProcessUsage Run(const Options& options, const std::vector<std::string>& arguments,
                       const fs::path& log) {
  std::vector<std::string> command{options.program.string()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return apps::RunProgram(command, log, {options.timeout_s, nullptr});
}

Vector3d LaserVector(const Json& json) {
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

/// True values of a simulated flight.
struct Truth {
  std::vector<MapPose> poses;
  Mounting mounting;
  double gsd_m = 0.0;
};

Truth ReadTruth(const fs::path& folder) {
  const Flight flight = ReadFlight(folder, {});
  Truth truth;
  truth.poses = ReadTrajectory(folder / "reference.out").ToMapPoses(flight.frame);
  truth.mounting = flight.config.lidar->mounting;
  truth.mounting.boresight_rad = *ReadTrueBoresightDeg(folder) * kRadPerDeg;
  truth.gsd_m = flight.config.lidar->gsd_m.value_or(0.0);
  return truth;
}

/// Sums over the pairs of one pair of strips in all flights.
struct PairErrors {
  double n = 0.0, normalised = 0.0, beyond_gsd = 0.0, beyond_999 = 0.0;
  Vector3d squares_m2 = Vector3d::Zero();  ///< along the track of i, across it, up
  Vector3d normalised_by_axis = Vector3d::Zero();
};

void AddPairs(const fs::path& folder, const std::string& file, const Truth& truth,
              PairErrors* errors) {
  for (const LidarPair& pair : ReadPairs(folder, {file}).pairs) {
    const MapPose pose_i = InterpolatePose(truth.poses, pair.t_i_s);
    const MapPose pose_j = InterpolatePose(truth.poses, pair.t_j_s);
    const Vector3d off_m = Georeference(pose_i, truth.mounting, pair.u_i_s) -
                           Georeference(pose_j, truth.mounting, pair.u_j_s);
    const Eigen::Vector2d along = pose_i.v_m.head<2>().normalized();
    Eigen::Matrix3d R_tm = Eigen::Matrix3d::Identity();  // t: along the track, across it, up
    R_tm.topLeftCorner<2, 2>() << along.x(), along.y(), -along.y(), along.x();
    const Vector3d squares_m2 = (R_tm * off_m).cwiseAbs2();
    errors->squares_m2 += squares_m2;
    errors->normalised_by_axis +=
        squares_m2.cwiseQuotient((R_tm * *pair.covariance_m2 * R_tm.transpose()).diagonal());
    const double normalised = off_m.dot(pair.covariance_m2->inverse() * off_m);
    errors->n += 1.0;
    errors->normalised += normalised / 3.0;
    errors->beyond_999 += normalised > kChiSquare3Of999 ? 1.0 : 0.0;
    errors->beyond_gsd += off_m.norm() > truth.gsd_m ? 1.0 : 0.0;
  }
}

/// Errors of one method over the flights.
struct MethodErrors {
  int results = 0;
  std::vector<double> nees;
  std::vector<double> nees_as_modelled;  ///< without the unmodelled effects in the covariance
  Vector3d squares_deg2 = Vector3d::Zero(), variances_deg2 = Vector3d::Zero();
  std::map<std::string, int> verdicts;
};

/// Angles with their covariance, compared with the truth.
struct AngleErrors {
  Vector3d error_deg;
  Eigen::Matrix3d covariance_deg2;

  double nees_by_3() const { return error_deg.dot(covariance_deg2.ldlt().solve(error_deg)) / 3.0; }
};

AngleErrors CompareAngles(const Json& angles, const Truth& truth) {
  const Vector3d found_rad = LaserVector(angles["angles_deg"]) * kRadPerDeg;
  AngleErrors out;
  out.error_deg = Log(Exp(found_rad) * Exp(truth.mounting.boresight_rad).conjugate()) / kRadPerDeg;
  for (int r = 0; r < 3; ++r) {
    out.covariance_deg2.row(r) = LaserVector(angles["covariance_deg2"][r]).transpose();
  }
  return out;
}

void AddResult(const fs::path& result_file, const Truth& truth, MethodErrors* errors) {
  const Json result = ReadJson(result_file);
  const Json& boresight = result["boresight"];
  const AngleErrors reported = CompareAngles(boresight, truth);
  ++errors->results;
  errors->nees.push_back(reported.nees_by_3());
  if (boresight.contains("as_modelled") && !boresight["as_modelled"].is_null()) {
    const AngleErrors modelled = CompareAngles(boresight["as_modelled"], truth);
    errors->nees_as_modelled.push_back(modelled.nees_by_3());
  }
  errors->squares_deg2 += reported.error_deg.cwiseAbs2();
  errors->variances_deg2 += reported.covariance_deg2.diagonal();
  ++errors->verdicts[result["assessment"]["verdict"].get<std::string>()];
}

struct Totals {
  double gsd_m = 0.0, cpu_s = 0.0;
  std::map<std::string, PairErrors> pairs;  ///< by pair of strips
  std::map<std::string, MethodErrors> methods;
};

void RunFlight(const Options& options, int seed, Totals* totals) {
  const fs::path flight = options.work / fmt::format("flight{}", seed);
  const fs::path out = options.work / fmt::format("result{}", seed);
  fs::remove_all(flight);
  fs::remove_all(out);
  std::vector<std::string> simulate{"simulate", options.scenario, "--seed", std::to_string(seed),
                                    "--out",    flight.string(),  "--set",  "strips=true",
                                    "--set",    "pairs.count=0"};
  for (const std::string& setting : options.settings)
    simulate.insert(simulate.end(), {"--set", setting});
  if (options.unmodelled > 0.0) {
    simulate.insert(simulate.end(), {"--draw-unmodelled", fmt::format("{}", options.unmodelled)});
  }
  const fs::path log = options.work / fmt::format("log{}", seed);
  if (Run(options, simulate, log).exit_code != 0) {
    throw std::runtime_error("dn simulate failed, see " + log.string());
  }
  totals->cpu_s += Run(options,
                       {"calibrate", flight.string(), "--method", "all", "--out", out.string(),
                        "--threads", std::to_string(options.threads)},
                       log)
                       .cpu_s;
  const Truth truth = ReadTruth(flight);
  totals->gsd_m = truth.gsd_m;
  for (const auto& file : fs::directory_iterator(out / "lidar")) {
    const std::string name = file.path().stem().string();
    AddPairs(out / "lidar", file.path().filename().string(), truth, &totals->pairs[name]);
  }
  for (const std::string& method : kMethods) {
    const fs::path result = out / ("result_" + method + ".json");
    if (fs::exists(result)) AddResult(result, truth, &totals->methods[method]);
  }
  if (options.keep) return;
  fs::remove_all(flight);
  fs::remove_all(out);
}

Json ToJson(const Vector3d& v) { return {v[0], v[1], v[2]}; }

Json Mean(const std::vector<double>& values) {
  if (values.empty()) return nullptr;
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

Json LoadJson(const Totals& totals, int flights) {
  Json json = {{"flights", flights}, {"gsd_m", totals.gsd_m}, {"cpu_s", totals.cpu_s}};
  for (const auto& [strips, e] : totals.pairs) {
    json["pairs"][strips] = {{"pairs_of_a_flight", e.n / flights},
                             {"rms_along_across_up_m", ToJson((e.squares_m2 / e.n).cwiseSqrt())},
                             {"rms_3d_by_gsd", std::sqrt(e.squares_m2.sum() / e.n) / totals.gsd_m},
                             {"normalised_variance", e.normalised / e.n},
                             {"normalised_along_across_up", ToJson(e.normalised_by_axis / e.n)},
                             {"beyond_gsd", e.beyond_gsd / e.n},
                             {"beyond_999", e.beyond_999 / e.n}};
  }
  for (const auto& [method, e] : totals.methods) {
    json["methods"][method] = {{"results", e.results},
                               {"nees_by_3", Mean(e.nees)},
                               {"nees", e.nees},
                               {"nees_by_3_as_modelled", Mean(e.nees_as_modelled)},
                               {"nees_as_modelled", e.nees_as_modelled},
                               {"rms_error_deg", ToJson((e.squares_deg2 / e.results).cwiseSqrt())},
                               {"sigma_deg", ToJson((e.variances_deg2 / e.results).cwiseSqrt())},
                               {"verdicts", e.verdicts}};
  }
  return json;
}

std::string Triple(const Json& v, double scale, const char* format) {
  std::string text;
  for (const Json& value : v) {
    if (!text.empty()) text += ", ";
    text += fmt::format(fmt::runtime(format), scale * value.get<double>());
  }
  return text;
}

void Print(const Json& json) {
  fmt::print("{:<8} {:>6} {:>24} {:>8} {:>10} {:>24} {:>10} {:>10}\n", "strips", "pairs",
             "rms along, across, up m", "3-D/GSD", "normalised", "along, across, up", "> GSD",
             "> 99.9 %");
  for (const auto& [strips, row] : json["pairs"].items()) {
    fmt::print("{:<8} {:>6.0f} {:>24} {:>8.2f} {:>10.2f} {:>24} {:>9.2f}% {:>9.2f}%\n", strips,
               row["pairs_of_a_flight"].get<double>(),
               Triple(row["rms_along_across_up_m"], 1.0, "{:.3f}"),
               row["rms_3d_by_gsd"].get<double>(), row["normalised_variance"].get<double>(),
               Triple(row["normalised_along_across_up"], 1.0, "{:.2f}"),
               100.0 * row["beyond_gsd"].get<double>(), 100.0 * row["beyond_999"].get<double>());
  }
  fmt::print("{:<8} {:>7} {:>8} {:>12} {:>24} {:>24}   {}\n", "method", "results", "NEES/3",
             "as modelled", "rms error r, p, y mdeg", "sigma", "verdicts");
  for (const auto& [method, row] : json["methods"].items()) {
    const Json& modelled = row["nees_by_3_as_modelled"];
    fmt::print("{:<8} {:>7} {:>8.2f} {:>12} {:>24} {:>24}   {}\n", method,
               row["results"].get<int>(), row["nees_by_3"].get<double>(),
               modelled.is_null() ? "-" : fmt::format("{:.2f}", modelled.get<double>()),
               Triple(row["rms_error_deg"], 1e3, "{:.1f}"), Triple(row["sigma_deg"], 1e3, "{:.1f}"),
               row["verdicts"].dump());
  }
  fmt::print("processor time of a flight: {:.0f} s\n",
             json["cpu_s"].get<double>() / json["flights"].get<double>());
}

int Main(int argc, char** argv) {
  Options options;
  CLI::App app{"Flights from point clouds alone against their truth"};
  app.add_option("SCENARIO", options.scenario, "Name or file")->required();
  app.add_option("--work", options.work, "Folder for flights and results")->required();
  app.add_option("--set", options.settings, "Changes of the scenario, KEY=VALUE");
  app.add_option("--flights", options.flights, "How many")->capture_default_str();
  app.add_option("--seed", options.first_seed, "Seed of the first flight")->capture_default_str();
  app.add_option("--threads", options.threads, "Of dn calibrate")->capture_default_str();
  app.add_option("--draw-unmodelled", options.unmodelled,
                 "Draw every unmodelled effect from its prior times this factor")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--json", options.json, "Write the figures here");
  app.add_option("--dn", options.program, "The program")->capture_default_str();
  app.add_flag("--keep", options.keep, "Keep flights and results");
  CLI11_PARSE(app, argc, argv);
  try {
    fs::create_directories(options.work);
    Totals totals;
    for (int k = 0; k < options.flights; ++k) {
      RunFlight(options, options.first_seed + k, &totals);
      const Json json = LoadJson(totals, k + 1);
      if (!options.json.empty()) std::ofstream(options.json) << FormatJson(json);
    }
    Print(LoadJson(totals, options.flights));
  } catch (const std::exception& error) {
    fmt::print(stderr, "matched_flights: {}\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace dn::bench

int main(int argc, char** argv) { return dn::bench::Main(argc, argv); }
