#pragma once

#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "nmea_sentence.h"

namespace dn::gnss_internal {

/// Beginning of a UTC day, written as if it were GPS time.
struct Day {
  double t_s;  ///< seconds since the GPS epoch
};

/// Date and time of day of one sentence, UTC.
struct Stamp {
  Day day;
  double time_of_day_s;
};

/// Chooses the sentence that dates the file: the first valid RMC whose day is that of most others
/// or next to it, else the first ZDA after the first position, else the last ZDA before it.
class DateFinder {
 public:
  void Take(const std::vector<std::string_view>& fields, bool after_first_fix,
            const FileLocation& where);

  std::optional<Stamp> stamp() const;
  /// Returns the number of RMC sentences with another day.
  long outliers() const;

 private:
  /// RMC sentences of one day: their number, and the first of them in the file.
  struct DayStamps {
    long count = 0, order = 0;
    Stamp first{};
  };

  /// Returns the day of most RMC sentences.
  double MostFrequentDay() const;

  std::map<double, DayStamps> rmc_;  ///< by the beginning of the day
  std::optional<Stamp> zda_;
  bool zda_is_after_ = false;
};

/// Returns whether a date may be 1024 weeks early. Receivers that miss the rollover of 2019 (week
/// 2048) state dates from 1999 on (week 1024); half a cycle later, true dates are as likely.
bool MayHaveMissedARollover(const Stamp& stamp);

}  // namespace dn::gnss_internal
