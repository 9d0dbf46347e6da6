#pragma once

#include <cmath>
#include <limits>

namespace dn {

inline constexpr double kLogZero = -std::numeric_limits<double>::infinity();

/// Accumulates log(sum of exp) of values that are added one by one.
class LogSum {
 public:
  void Add(double log_value) {
    if (log_value == kLogZero) return;
    if (log_value > largest_) {
      sum_ *= std::exp(largest_ - log_value);
      largest_ = log_value;
    }
    sum_ += std::exp(log_value - largest_);
  }
  double Value() const { return sum_ > 0.0 ? largest_ + std::log(sum_) : kLogZero; }

 private:
  double largest_ = kLogZero;
  double sum_ = 0.0;
};

}  // namespace dn
