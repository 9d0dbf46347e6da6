/// run_matching: simulates two strips of several sizes at one point density and runs `dn match` on
/// them. Prints time and memory by number of points, and the exponents of their growth.
#include <dn/report/json_reader.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "child_process.h"

namespace dn::bench {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path program = DN_PROGRAM;
  fs::path work;
  fs::path json;
  std::vector<double> line_lengths_m{375.0, 750.0, 1500.0};
  int threads = 2;
  double timeout_s = 1800.0;
};

/// Returns a scenario with two opposite lines over mixed terrain, with 30,000 points per second at
/// 45 m/s: a million points on 1,500 m.
std::string ScenarioText(double line_length_m) {
  const double half_m = 0.5 * line_length_m;
  return fmt::format(
      "name: two_strips_{0:.0f}m\n"
      "origin_deg_m: [46.57, 6.52, 0]\n"
      "start_s: 381000\n"
      "plan:\n"
      "  warm_up_s: 300\n"
      "  lines:\n"
      "    - [-{1}, 0, {1}, 0, 700, 45]\n"
      "    - [{1}, 120, -{1}, 120, 700, 45]\n"
      "  bank_deg: 25\n"
      "  turbulence: {{roll_deg: 1.0, pitch_deg: 0.7, heading_deg: 0.7, speed_m_s: 1.0, height_m: "
      "2.0}}\n"
      "terrain: {{kind: mixed, base_m: 525, relief_m: 60, wavelength_m: 900, buildings_per_km2: "
      "300, trees_per_km2: 0, seed: 1}}\n"
      "imu: {{rate_hz: 200, preset: airins}}\n"
      "gnss: {{rate_hz: 1, sigma_enu_m: [0.015, 0.015, 0.03], lever_arm_m: [0.4, -0.1, -1.1]}}\n"
      "lidar:\n"
      "  R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]]\n"
      "  scan_axis: [0, 1, 0]\n"
      "  nadir_axis: [1, 0, 0]\n"
      "  lever_arm_m: [0.14, -0.02, 0.21]\n"
      "  boresight_deg: [0.2, 0.03, 0.35]\n"
      "  fov_deg: 75\n"
      "  pulse_rate_hz: 30000\n"
      "  gsd_m: 0.65\n"
      "pairs: {{count: 100}}\n"
      "strips: true\n",
      line_length_m, half_m);
}

Json ReadJson(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return ParseJson(text.str(), file.string());
}

apps::ProcessUsage Run(const Options& options, const std::vector<std::string>& arguments,
                       const std::string& name) {
  std::vector<std::string> command{options.program.string()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const fs::path log = options.work / (name + ".log");
  const apps::ProcessUsage usage = apps::RunProgram(command, log, {options.timeout_s, nullptr});
  if (usage.exit_code != 0) {
    throw std::runtime_error("dn " + arguments.front() + " failed, see " + log.string());
  }
  return usage;
}

Json RunCase(const Options& options, double line_length_m) {
  const std::string name = fmt::format("{:.0f}m", line_length_m);
  const fs::path scenario = options.work / (name + ".yaml"), flight = options.work / name;
  std::ofstream(scenario) << ScenarioText(line_length_m);
  if (!fs::exists(flight / "flight.yaml")) {
    Run(options, {"simulate", scenario.string(), "--seed", "1", "--out", flight.string()},
        name + "-simulate");
  }
  const fs::path out = options.work / (name + "-match");
  fs::remove_all(out);
  const apps::ProcessUsage usage = Run(options,
                                       {"match", flight.string(), "--out", out.string(),
                                        "--threads", std::to_string(options.threads)},
                                       name + "-match");
  const Json match = ReadJson(out / "match.json");
  long points = 0;
  for (const Json& strip : match["strips"]) points += strip["points"].get<long>();
  return {{"line_length_m", line_length_m},
          {"points", points},
          {"pairs", match["counts"]["pairs"]},
          {"wall_s", usage.wall_s},
          {"cpu_s", usage.cpu_s},
          {"peak_rss_mib", usage.peak_rss_mib}};
}

double Exponent(const Json& smaller, const Json& larger, const char* key) {
  return std::log(larger[key].get<double>() / smaller[key].get<double>()) /
         std::log(larger["points"].get<double>() / smaller["points"].get<double>());
}

void Print(const Json& cases) {
  fmt::print("{:>10} {:>10} {:>8} {:>8} {:>8}   {}\n", "points", "pairs", "wall s", "cpu s", "MiB",
             "growth of cpu");
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const Json& row = cases[k];
    fmt::print("{:>10} {:>10} {:>8.1f} {:>8.1f} {:>8.0f}   {}\n", row["points"].get<long>(),
               row["pairs"].dump(), row["wall_s"].get<double>(), row["cpu_s"].get<double>(),
               row["peak_rss_mib"].get<double>(),
               k == 0 ? "" : fmt::format("points^{:.2f}", Exponent(cases[k - 1], row, "cpu_s")));
  }
}

int Main(int argc, char** argv) {
  Options options;
  CLI::App app{"Whole-program benchmark: dn match on two strips of several lengths"};
  app.add_option("--work", options.work, "Folder for flights (kept) and results")->required();
  app.add_option("--json", options.json, "Write the figures here");
  app.add_option("--dn", options.program, "The program")->capture_default_str();
  app.add_option("--lengths", options.line_lengths_m, "Length of the lines, m")->delimiter(',');
  app.add_option("--threads", options.threads, "Of dn match")->capture_default_str();
  app.add_option("--timeout", options.timeout_s, "Time limit of one program run, s")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    fs::create_directories(options.work);
    Json cases = Json::array();
    for (const double length_m : options.line_lengths_m) {
      cases.push_back(RunCase(options, length_m));
    }
    if (!options.json.empty()) std::ofstream(options.json) << FormatJson(cases);
    Print(cases);
  } catch (const std::exception& error) {
    fmt::print(stderr, "run_matching: {}\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace dn::bench

int main(int argc, char** argv) { return dn::bench::Main(argc, argv); }
