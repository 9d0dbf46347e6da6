#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace dn::diagnosis_internal {

/// Measures the durations of consecutive parts of some work.
class Stopwatch {
 public:
  explicit Stopwatch(std::vector<std::pair<std::string, double>>* laps) : laps_(laps) {}

  /// Ends a part and stores its duration, s.
  void Lap(const std::string& name) {
    const auto now = std::chrono::steady_clock::now();
    laps_->emplace_back(name, std::chrono::duration<double>(now - start_).count());
    start_ = now;
  }

 private:
  std::vector<std::pair<std::string, double>>* laps_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace dn::diagnosis_internal
