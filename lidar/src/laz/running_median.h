#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dn::lidar_internal::laz {

/// Approximate median of recent values: five sorted values, where each new value replaces the
/// largest or the smallest one.
class RunningMedian {
 public:
  std::int32_t median() const { return sorted_[2]; }

  void Add(std::int32_t value) {
    if (replaces_largest_) {
      replaces_largest_ = value < sorted_[2];
      std::size_t at = 4;
      for (; at > 0 && value < sorted_[at - 1]; --at) sorted_[at] = sorted_[at - 1];
      sorted_[at] = value;
    } else {
      replaces_largest_ = value <= sorted_[2];
      std::size_t at = 0;
      for (; at < 4 && sorted_[at + 1] < value; ++at) sorted_[at] = sorted_[at + 1];
      sorted_[at] = value;
    }
  }

 private:
  std::array<std::int32_t, 5> sorted_{};
  bool replaces_largest_ = true;
};

}  // namespace dn::lidar_internal::laz
