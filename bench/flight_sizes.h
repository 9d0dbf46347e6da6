#pragma once

#include <string>
#include <vector>

namespace dn::bench {

/// A flight of a given length: the low-altitude scenario with a shorter or longer warm-up and
/// block.
struct FlightSize {
  std::string name;  ///< "20min"
  double warm_up_s = 0.0;
  int parallel_lines = 0;  ///< 120 m apart, flown in alternating directions
  int cross_lines = 0;     ///< across their middle, 500 m apart, 60 m higher
  double line_length_m = 0.0;
  long pairs = 0;
  int blocks = 1;  ///< of so many lines, 6 km apart, one after the other
};

/// 5min with 1,000 pairs, 10min with 20,000, 20min with 5,000, 60min with 20,000; 2, 4 and 8 hours of
/// one block that grows, and of blocks of an hour each.
const std::vector<FlightSize>& FlightSizes();

/// The size of that name. Throws std::out_of_range when there is none.
const FlightSize& SizeByName(const std::string& name);

/// Scenario file of the size with an inertial sensor of the shipped presets ("airins", "apx15").
std::string ScenarioText(const FlightSize& size, const std::string& imu_preset);

}  // namespace dn::bench
