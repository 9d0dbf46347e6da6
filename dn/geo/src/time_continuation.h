#pragma once

#include <dn/geo/text_table.h>

#include <algorithm>
#include <cstddef>

namespace dn::geo_internal {

/// A step back by a week counts as a rollover if the pause at the rollover is at most this long.
inline constexpr double kLongestPauseAtRolloverS = 3600.0;

/// Makes a time column continuous over week rollovers, row after row.
class TimeContinuation {
 public:
  enum class Verdict {
    kKeep,
    kRepeatedRow,    ///< identical to the previous row
    kNotIncreasing,  ///< neither increasing nor a rollover
  };

  /// Judges the next row, whose first value is its time, and makes that time continuous in place.
  /// Rows judged kNotIncreasing are not changed.
  Verdict Next(double* row, std::size_t columns) {
    double t_s = row[0] + offset_s_;
    if (last_ != nullptr) {
      const double step_s = t_s - last_[0];
      if (step_s == 0.0 && std::equal(row + 1, row + columns, last_ + 1)) {
        row[0] = t_s;
        return Verdict::kRepeatedRow;
      }
      const double since_last_s = step_s + kWeekS;  // time step if the week ended in between
      if (step_s < 0.0 && since_last_s > 0.0 && since_last_s <= kLongestPauseAtRolloverS) {
        offset_s_ += kWeekS;
        t_s += kWeekS;
      } else if (!(step_s > 0.0)) {
        return Verdict::kNotIncreasing;
      }
    }
    row[0] = t_s;
    last_ = row;
    return Verdict::kKeep;
  }

  /// Returns the continuous time of the last kept row.
  double last_s() const { return last_[0]; }
  double offset_s() const { return offset_s_; }

 private:
  const double* last_ = nullptr;
  double offset_s_ = 0.0;
};

}  // namespace dn::geo_internal
