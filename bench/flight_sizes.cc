#include "flight_sizes.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace dn::bench {
namespace {

constexpr double kParallelSpacing_m = 120.0;
constexpr double kCrossSpacing_m = 500.0;
constexpr double kHeight_m = 700.0;
constexpr double kCrossHeight_m = 760.0;
constexpr double kSpeed_mps = 45.0;

/// Distance between the middles of consecutive blocks, east.
constexpr double kBlockDistance_m = 6000.0;

/// Returns the position of line `index` of `count` relative to the middle of the block.
double Offset(int index, int count, double spacing_m) {
  return spacing_m * (index - 0.5 * (count - 1));
}

std::string Lines(const FlightSize& size, int block) {
  const double middle_east = Offset(block, size.blocks, kBlockDistance_m);
  std::string text;
  for (int k = 0; k < size.parallel_lines + size.cross_lines; ++k) {
    const bool cross = k >= size.parallel_lines;
    double from = -0.5 * size.line_length_m;
    double to = -from;
    if (k % 2 == 1) std::swap(from, to);
    if (cross) {
      const double east =
          middle_east + Offset(k - size.parallel_lines, size.cross_lines, kCrossSpacing_m);
      text += fmt::format("    - [{}, {}, {}, {}, {}, {}]\n", east, from, east, to, kCrossHeight_m,
                          kSpeed_mps);
    } else {
      const double north = Offset(k, size.parallel_lines, kParallelSpacing_m);
      text += fmt::format("    - [{}, {}, {}, {}, {}, {}]\n", middle_east + from, north,
                          middle_east + to, north, kHeight_m, kSpeed_mps);
    }
  }
  return text;
}

std::string Lines(const FlightSize& size) {
  std::string text;
  for (int block = 0; block < size.blocks; ++block) text += Lines(size, block);
  return text;
}

}  // namespace

const std::vector<FlightSize>& FlightSizes() {
  static const std::vector<FlightSize> sizes{
      {"5min", 90.0, 2, 0, 1000.0, 1000},           {"10min", 225.0, 2, 1, 1500.0, 20000},
      {"20min", 725.0, 2, 1, 3000.0, 5000},         {"60min", 900.0, 14, 2, 3000.0, 20000},
      {"120min", 900.0, 37, 4, 3000.0, 42000},      {"240min", 900.0, 80, 8, 3000.0, 85000},
      {"480min", 900.0, 167, 15, 3000.0, 171000},   {"2-blocks", 900.0, 14, 2, 3000.0, 40000, 2},
      {"4-blocks", 900.0, 14, 2, 3000.0, 80000, 4}, {"8-blocks", 900.0, 14, 2, 3000.0, 160000, 8},
  };
  return sizes;
}

const FlightSize& SizeByName(const std::string& name) {
  const auto& sizes = FlightSizes();
  const auto found = std::find_if(sizes.begin(), sizes.end(),
                                  [&](const FlightSize& size) { return size.name == name; });
  if (found == sizes.end()) throw std::out_of_range("no flight size '" + name + "'");
  return *found;
}

std::string ScenarioText(const FlightSize& size, const std::string& imu_preset) {
  return fmt::format(R"(name: {}-{}
origin_deg_m: [46.57, 6.52, 0]
start_s: 381000
plan:
  warm_up_s: {}
  lines:
{}  bank_deg: 25
  turbulence: {{roll_deg: 1.0, pitch_deg: 0.7, heading_deg: 0.7, speed_m_s: 1.0, height_m: 2.0}}
  crab_deg: 3
terrain: {{kind: mixed, base_m: 525, relief_m: 60, wavelength_m: 900, buildings_per_km2: 300,
          trees_per_km2: 0, seed: 1}}
imu: {{rate_hz: 200, preset: {}}}
gnss: {{rate_hz: 1, sigma_enu_m: [0.015, 0.015, 0.03], lever_arm_m: [0.4, -0.1, -1.1]}}
lidar:
  R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
  scan_axis: [0, 1, 0]
  nadir_axis: [1, 0, 0]
  lever_arm_m: [0.14, -0.02, 0.21]
  boresight_deg: [0.2, 0.03, 0.35]
  fov_deg: 75
  pulse_rate_hz: 200000
  gsd_m: 0.2
  beam_divergence_mrad: 0.35
pairs: {{count: {}}}
)",
                     imu_preset, size.name, size.warm_up_s, Lines(size), imu_preset, size.pairs);
}

}  // namespace dn::bench
