#pragma once

#include <string>
#include <vector>

namespace dn::bench {

/// A flight of a given length: the low-altitude scenario with a shorter or longer warm-up and
/// block.
struct FlightSize {
  std::string name;  ///< for example "20min"
  double warm_up_s = 0.0;
  int parallel_lines = 0;  ///< 120 m apart, flown in alternating directions
  int cross_lines = 0;     ///< across the middle of the parallel lines, 500 m apart, 60 m higher
  double line_length_m = 0.0;
  long pairs = 0;
  int blocks = 1;  ///< number of blocks with these lines, 6 km apart, flown one after the other
};

/// Returns the sizes: 5 min with 1,000 pairs, 10 min with 20,000, 20 min with 5,000, and 60 min
/// with 20,000. Flights of 2, 4 and 8 hours exist as one growing block and as blocks of one hour
/// each.
const std::vector<FlightSize>& FlightSizes();

/// Returns the size with this name. Throws std::out_of_range for an unknown name.
const FlightSize& SizeByName(const std::string& name);

/// Returns the scenario file of the size with the inertial sensor of a shipped preset ("airins",
/// "apx15").
std::string ScenarioText(const FlightSize& size, const std::string& imu_preset);

}  // namespace dn::bench
