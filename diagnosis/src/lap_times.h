#pragma once

#include <dn/stopwatch.h>

#include <string>
#include <utility>
#include <vector>

namespace dn::diagnosis_internal {

/// Measures the durations of consecutive parts of some work.
class LapTimes {
 public:
  explicit LapTimes(std::vector<std::pair<std::string, double>>* laps) : laps_(laps) {}

  /// Ends a part and stores its duration, s.
  void Lap(const std::string& name) { laps_->emplace_back(name, watch_.Restart()); }

 private:
  std::vector<std::pair<std::string, double>>* laps_;
  Stopwatch watch_;
};

}  // namespace dn::diagnosis_internal
