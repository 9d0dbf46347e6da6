#pragma once

#include <chrono>

namespace dn {

/// Measures wall-clock time from its construction.
class Stopwatch {
 public:
  /// Returns the time since the start, s.
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  /// Returns the time since the start, s, and starts again.
  double Restart() {
    const double elapsed_s = seconds();
    start_ = Clock::now();
    return elapsed_s;
  }

 private:
  using Clock = std::chrono::steady_clock;

  Clock::time_point start_ = Clock::now();
};

}  // namespace dn
