#include "memory_advice.h"

#include <map>

namespace dn::apps {

std::string MemoryAdvice(const std::string& command) {
  static const std::map<std::string, std::string> advice{
      {"calibrate", "lower network.node_rate_hz or thin the pairs (lidar.pairs)"},
      {"smooth", "lower network.node_rate_hz or limit time_span_s"},
      {"gap", "lower network.node_rate_hz, thin the pairs (lidar.pairs) or give --quick"},
      {"match", "give a larger --gsd, or fewer or shorter strips"},
      {"georef", "give a smaller --threads, or a trajectory with a lower rate"},
      {"simulate", "lower pairs.count, imu.rate_hz or lidar.pulse_rate_hz of the scenario"},
      {"study", "lower pairs.count and imu.rate_hz of the scenario, or give a smaller --threads"},
      {"monte-carlo", "give a smaller --threads: each of them adjusts a flight"},
      {"blind-check", "give a smaller --threads: each of them diagnoses a flight"},
      {"merge", "merge a series of fewer flights or designs"},
      {"report", "give fewer folders"}};
  const auto at = advice.find(command);
  return at == advice.end() ? "allow the process more, or shorten the files" : at->second;
}

}  // namespace dn::apps
