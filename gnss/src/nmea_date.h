#pragma once

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

/// Chooses the sentence that dates the file: the first valid RMC, else the first ZDA after the
/// first position, else the last ZDA before it.
class DateFinder {
 public:
  void Take(const std::vector<std::string_view>& fields, bool after_first_fix,
            const FileLocation& where);

  std::optional<Stamp> stamp() const { return rmc_ ? rmc_ : zda_; }

 private:
  std::optional<Stamp> rmc_, zda_;
  bool zda_is_after_ = false;
};

/// Returns whether a date may be 1024 weeks early. Receivers that miss the rollover of 2019 (week
/// 2048) state dates from 1999 on (week 1024); half a cycle later, true dates are as likely.
bool MayHaveMissedARollover(const Stamp& stamp);

}  // namespace dn::gnss_internal
