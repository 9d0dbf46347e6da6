/// run_sizes: simulates flights of several lengths, runs `dn calibrate` on each as a user would,
/// and prints and writes the time and memory used.
#include <dn/report/json_reader.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "child_process.h"
#include "flight_sizes.h"

namespace dn::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kLargestSigmaChange = 0.01;
constexpr const char* kAutoRate = "node_rate_hz: auto";

struct Options {
  fs::path program = DN_PROGRAM;
  fs::path work;
  fs::path json;
  std::vector<std::string> sizes{"5min", "10min", "20min", "60min"};
  std::vector<std::string> grades{"lar", "uav"};
  double reference_rate_hz = 10.0;
  int threads = 0;
  int seed = 1;
  double timeout_s = 600.0;
  bool rate_check = true;
};

/// Agreed limits of time and memory for one case, from reading the data to writing the covariances.
struct Goal {
  std::string size;
  std::string grade;
  double total_s = 0.0;
  std::optional<double> rss_mib;
};

const std::vector<Goal>& Goals() {
  static const std::vector<Goal> goals{{"20min", "lar", 15.0, 1500.0},
                                       {"20min", "uav", 40.0, std::nullopt},
                                       {"10min", "lar", 20.0, std::nullopt}};
  return goals;
}

const char* SizePreset(const std::string& grade) { return grade == "uav" ? "apx15" : "airins"; }

std::string ReadText(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

void WriteText(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

/// Returns the text after ": " in the first line of a /proc file that starts with the key.
std::string ProcValue(const fs::path& file, const std::string& key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(key, 0) != 0) continue;
    const auto colon = line.find(':');
    const auto begin = line.find_first_not_of(" \t", colon + 1);
    return begin == std::string::npos ? std::string() : line.substr(begin);
  }
  return "unknown";
}

Json Machine() {
  std::array<double, 1> load{};
  if (getloadavg(load.data(), 1) != 1) load[0] = std::nan("");
  return {{"cpu", ProcValue("/proc/cpuinfo", "model name")},
          {"cores", std::thread::hardware_concurrency()},
          {"memory", ProcValue("/proc/meminfo", "MemTotal")},
          {"compiler", __VERSION__},
          {"load_average_at_start", load[0]}};
}

/// Simulates the flight unless its folder already exists; returns the folder.
fs::path Simulated(const Options& options, const FlightSize& size, const std::string& grade) {
  fs::path flight = options.work / fmt::format("{}-{}-seed{}", grade, size.name, options.seed);
  if (fs::exists(flight / "flight.yaml")) return flight;
  const fs::path scenario = options.work / fmt::format("{}-{}.yaml", grade, size.name);
  WriteText(scenario, ScenarioText(size, SizePreset(grade)));
  fmt::print(stderr, "simulating {}\n", flight.string());
  const fs::path log = options.work / "simulate.log";
  const apps::ProcessUsage usage =
      apps::RunProgram({options.program, "simulate", scenario, "--seed",
                        std::to_string(options.seed), "--out", flight},
                       log, {options.timeout_s, nullptr});
  if (usage.exit_code != 0) {
    throw std::runtime_error("dn simulate failed, exit code " + std::to_string(usage.exit_code) +
                             ":\n" + ReadText(log));
  }
  return flight;
}

/// Creates a second folder that links to the same data and has another node rate; returns it.
fs::path WithNodeRate(const fs::path& flight, double rate_hz) {
  fs::path copy = flight;
  copy += fmt::format("-{}hz", rate_hz);
  fs::create_directories(copy);
  for (const auto& entry : fs::directory_iterator(flight)) {
    const fs::path name = entry.path().filename();
    if (name == "flight.yaml" || fs::exists(copy / name)) continue;
    fs::create_symlink(fs::absolute(entry.path()), copy / name);
  }
  std::string config = ReadText(flight / "flight.yaml");
  const auto at = config.find(kAutoRate);
  if (at == std::string::npos) {
    throw std::runtime_error((flight / "flight.yaml").string() + ": no '" + kAutoRate + "'");
  }
  config.replace(at, std::string(kAutoRate).size(), fmt::format("node_rate_hz: {}", rate_hz));
  WriteText(copy / "flight.yaml", config);
  return copy;
}

/// Calibrates a flight and collects its figures; returns {"failed": reason} if it fails.
Json Calibrated(const Options& options, const fs::path& flight) {
  fs::path out = options.work / "results" / flight.filename();
  fs::remove_all(out);
  fs::create_directories(out.parent_path());
  fs::path log = out;
  log += ".log";
  std::vector<std::string> command{options.program, "calibrate", flight, "--out", out};
  if (options.threads > 0) {
    command.insert(command.end(), {"--threads", std::to_string(options.threads)});
  }
  fmt::print(stderr, "calibrating {}\n", flight.string());
  const apps::ProcessUsage usage = apps::RunProgram(command, log, {options.timeout_s, nullptr});
  Json row{{"wall_s", usage.wall_s}, {"cpu_s", usage.cpu_s}, {"peak_rss_mib", usage.peak_rss_mib}};
  if (usage.exit_code != 0) {
    row["failed"] = usage.exit_code > 128 ? fmt::format("not finished in {} s", options.timeout_s)
                                          : "exit code " + std::to_string(usage.exit_code);
    return row;
  }
  const Json result = ParseJson(ReadText(out / "result.json"), "result.json");
  const Json report = ParseJson(ReadText(out / "report.json"), "report.json");
  row["timing_s"] = result["timing_s"];
  for (const char* key : {"nodes", "parameters", "iterations", "imu_epochs", "correspondences"}) {
    row[key] = result["adjustment"][key];
  }
  row["node_rate_hz"] = report["node_rate_hz"];
  row["angles_deg"] = result["boresight"]["angles_deg"];
  row["sigma_deg"] = result["boresight"]["sigma_deg"];
  row["stages"] = report["stages"];
  return row;
}

/// Returns the largest relative change of the sigmas, and the largest shift of an angle in sigmas.
Json Compared(const Json& automatic, const Json& reference) {
  double sigma_change = 0.0;
  double shift = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double sigma = reference["sigma_deg"][i];
    sigma_change =
        std::max(sigma_change, std::abs(automatic["sigma_deg"][i].get<double>() / sigma - 1.0));
    shift = std::max(shift, std::abs(automatic["angles_deg"][i].get<double>() -
                                     reference["angles_deg"][i].get<double>()) /
                                sigma);
  }
  return {{"largest_sigma_change", sigma_change},
          {"largest_shift_sigmas", shift},
          {"within_1_percent", sigma_change <= kLargestSigmaChange}};
}

Json TimeGoal(const std::string& size, const std::string& grade, const Json& row) {
  const auto goal = std::find_if(Goals().begin(), Goals().end(),
                                 [&](const Goal& g) { return g.size == size && g.grade == grade; });
  if (goal == Goals().end()) return nullptr;
  Json json{{"total_s", goal->total_s}};
  bool met = !row.contains("failed") && row["timing_s"]["total"] <= goal->total_s;
  if (goal->rss_mib) {
    json["peak_rss_mib"] = *goal->rss_mib;
    met = met && row["peak_rss_mib"] <= *goal->rss_mib;
  }
  json["met"] = met;
  return json;
}

Json RunCase(const Options& options, const FlightSize& size, const std::string& grade) {
  const fs::path flight = Simulated(options, size, grade);
  Json entry{{"size", size.name}, {"grade", grade}, {"pairs", size.pairs}};
  entry["auto"] = Calibrated(options, flight);
  entry["goal"] = TimeGoal(size.name, grade, entry["auto"]);
  if (!options.rate_check) return entry;
  Json& reference = entry["reference_rate"];
  reference = Calibrated(options, WithNodeRate(flight, options.reference_rate_hz));
  if (!entry["auto"].contains("failed") && !reference.contains("failed")) {
    entry["auto_against_reference"] = Compared(entry["auto"], reference);
  }
  return entry;
}

void PrintRow(const Json& entry, const char* which) {
  if (!entry.contains(which)) return;
  const Json& row = entry[which];
  const std::string name =
      fmt::format("{} {}", entry["grade"].get<std::string>(), entry["size"].get<std::string>());
  if (row.contains("failed")) {
    fmt::print("{:<10} {:>6}  {} (wall {:.1f} s, {:.0f} MiB)\n", name, entry["pairs"].get<long>(),
               row["failed"].get<std::string>(), row["wall_s"].get<double>(),
               row["peak_rss_mib"].get<double>());
    return;
  }
  const Json& t = row["timing_s"];
  fmt::print(
      "{:<10} {:>6} {:>4.0f} {:>6} {:>7} {:>4} {:>6.2f} {:>6.2f} {:>6.2f} {:>6.2f} {:>6.2f} "
      "{:>6.2f} {:>6.0f}  {:.6f} {:.6f} {:.6f}\n",
      name, entry["pairs"].get<long>(), row["node_rate_hz"].get<double>(), row["nodes"].get<long>(),
      row["parameters"].get<long>(), row["iterations"].get<int>(), t["read"].get<double>(),
      t["solve"].get<double>(), t["covariance"].get<double>(), t["total"].get<double>(),
      row["wall_s"].get<double>(), row["cpu_s"].get<double>(), row["peak_rss_mib"].get<double>(),
      row["sigma_deg"][0].get<double>(), row["sigma_deg"][1].get<double>(),
      row["sigma_deg"][2].get<double>());
}

void PrintTable(const Json& results) {
  fmt::print("{}\n", results["machine"].dump());
  fmt::print("{:<10} {:>6} {:>4} {:>6} {:>7} {:>4} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6}  {}\n",
             "flight", "pairs", "Hz", "nodes", "unkn.", "it.", "read", "solve", "cov.", "total",
             "wall", "cpu", "MiB", "sigma of roll, pitch, yaw [deg]");
  for (const Json& entry : results["cases"]) {
    PrintRow(entry, "auto");
    PrintRow(entry, "reference_rate");
    if (entry.contains("auto_against_reference")) {
      const Json& change = entry["auto_against_reference"];
      fmt::print("{:<10} sigmas change by {:.3f} % at most, angles by {:.3f} sigma\n", "",
                 100.0 * change["largest_sigma_change"].get<double>(),
                 change["largest_shift_sigmas"].get<double>());
    }
    if (!entry["goal"].is_null()) {
      fmt::print("{:<10} goal {:.0f} s{}: {}\n", "", entry["goal"]["total_s"].get<double>(),
                 entry["goal"].contains("peak_rss_mib")
                     ? fmt::format(", {:.0f} MiB", entry["goal"]["peak_rss_mib"].get<double>())
                     : "",
                 entry["goal"]["met"].get<bool>() ? "met" : "missed");
    }
  }
}

void Run(const Options& options) {
  fs::create_directories(options.work);
  Json results{{"schema", "dn.bench.sizes/1"}, {"machine", Machine()}, {"seed", options.seed}};
  results["cases"] = Json::array();
  for (const std::string& size : options.sizes) {
    for (const std::string& grade : options.grades) {
      results["cases"].push_back(RunCase(options, SizeByName(size), grade));
      if (!options.json.empty()) WriteText(options.json, FormatJson(results));
    }
  }
  PrintTable(results);
}

int Main(int argc, char** argv) {
  Options options;
  std::vector<std::string> names;
  for (const FlightSize& size : FlightSizes()) names.push_back(size.name);
  CLI::App app{"Whole-program benchmark: dn calibrate on simulated flights of several lengths"};
  app.add_option("--work", options.work, "Folder for flights (kept) and results")->required();
  app.add_option("--json", options.json, "Write the figures here");
  app.add_option("--dn", options.program, "The program")->capture_default_str();
  app.add_option("--sizes", options.sizes, "Flights")->check(CLI::IsMember(names))->delimiter(',');
  app.add_option("--grades", options.grades, "Inertial sensors")
      ->check(CLI::IsMember({"lar", "uav"}))
      ->delimiter(',');
  app.add_option("--reference-rate", options.reference_rate_hz, "Node rate to compare with, Hz")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("!--no-rate-check", options.rate_check, "Only the default node rate");
  app.add_option("--threads", options.threads, "Threads of dn calibrate; 0: its default");
  app.add_option("--seed", options.seed, "Of the simulation")->capture_default_str();
  app.add_option("--timeout", options.timeout_s, "Time limit of one program run, s")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    Run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "run_sizes: {}\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace dn::bench

int main(int argc, char** argv) { return dn::bench::Main(argc, argv); }
