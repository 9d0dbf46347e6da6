/// linear_algebra: runs whole jobs on five networks with the project's own factorisation and with
/// CHOLMOD's in turn, and prints the medians of time and memory.
#include <dn/report/json.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "child_process.h"
#include "flight_sizes.h"

namespace dn::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kTimeout_s = 1800.0;
constexpr std::array<const char*, 2> kChoices{"multifrontal", "cholmod"};

struct Options {
  fs::path program = DN_PROGRAM;
  fs::path pose_graph = DN_POSE_GRAPH;
  fs::path work;
  fs::path json;
  int threads = 2;
  int repeats = 3;
};

struct Job {
  std::string name;
  std::vector<std::string> command;
};

apps::ProcessUsage Run(const Options& options, const std::vector<std::string>& command) {
  const fs::path log = options.work / "run.log";
  const apps::ProcessUsage usage = apps::RunProgram(command, log, {kTimeout_s, nullptr});
  if (usage.exit_code != 0)
    throw std::runtime_error(command.front() + " failed, see " + log.string());
  return usage;
}

/// Returns the job that calibrates a simulated flight; `scenario` is a file or a shipped scenario.
Job CalibrateJob(const Options& options, const std::string& name, const std::string& scenario) {
  const fs::path flight = options.work / name;
  if (!fs::exists(flight / "flight.yaml")) {
    Run(options, {options.program, "simulate", scenario, "--seed", "1", "--out", flight});
  }
  return {name,
          {options.program, "calibrate", flight, "--threads", std::to_string(options.threads),
           "--out", options.work / "result"}};
}

Job HourJob(const Options& options, const std::string& name, const std::string& imu) {
  const fs::path scenario = options.work / (name + ".yaml");
  std::ofstream(scenario) << ScenarioText(SizeByName("60min"), imu);
  return CalibrateJob(options, name, scenario);
}

std::vector<Job> Jobs(const Options& options) {
  return {CalibrateJob(options, "leg2", "leg2"),
          HourJob(options, "lar 60 min", "airins"),
          HourJob(options, "uav 60 min", "apx15"),
          CalibrateJob(options, "hal2", "hal2"),
          {"pose graph", {options.pose_graph, "--benchmark_filter=BM_SolveAndAllPoses"}}};
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Json RunJob(const Options& options, const Job& job) {
  std::array<std::vector<double>, 2> wall_s, cpu_s, mib;
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    for (std::size_t k = 0; k < kChoices.size(); ++k) {
      ::setenv("DN_LINEAR_ALGEBRA", kChoices[k], 1);
      const apps::ProcessUsage usage = Run(options, job.command);
      wall_s[k].push_back(usage.wall_s);
      cpu_s[k].push_back(usage.cpu_s);
      mib[k].push_back(usage.peak_rss_mib);
    }
  }
  Json row{{"job", job.name}};
  for (std::size_t k = 0; k < kChoices.size(); ++k) {
    row[kChoices[k]] = {{"wall_s", Median(wall_s[k])},
                        {"cpu_s", Median(cpu_s[k])},
                        {"peak_rss_mib", Median(mib[k])}};
  }
  return row;
}

void Print(const Json& row) {
  fmt::print("{:<12}", row["job"].get<std::string>());
  for (const char* key : {"wall_s", "cpu_s", "peak_rss_mib"}) {
    const double own = row[kChoices[0]][key], cholmod = row[kChoices[1]][key];
    fmt::print("  {} {:.2f} {:.2f} saved {:.0f} %", key, own, cholmod,
               100.0 * (1.0 - own / cholmod));
  }
  fmt::print("\n");
}

int Main(int argc, char** argv) {
  Options options;
  CLI::App app{"Whole-program benchmark: the own sparse factorisation and CHOLMOD's"};
  app.add_option("--work", options.work, "Folder for flights (kept) and results")->required();
  app.add_option("--json", options.json, "Write the figures here");
  app.add_option("--dn", options.program, "The program")->capture_default_str();
  app.add_option("--threads", options.threads, "Of dn calibrate")->capture_default_str();
  app.add_option("--repeats", options.repeats, "Runs of each job")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    fs::create_directories(options.work);
    Json rows = Json::array();
    for (const Job& job : Jobs(options)) {
      rows.push_back(RunJob(options, job));
      Print(rows.back());
    }
    if (!options.json.empty()) std::ofstream(options.json) << FormatJson(rows);
  } catch (const std::exception& error) {
    fmt::print(stderr, "linear_algebra: {}\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace dn::bench

int main(int argc, char** argv) { return dn::bench::Main(argc, argv); }
