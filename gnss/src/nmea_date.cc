#include "nmea_date.h"

#include <dn/geo/gps_time.h>
#include <dn/geo/text_table.h>

#include <algorithm>
#include <cmath>

namespace dn::gnss_internal {
namespace {

Day MakeDay(int year, int month, int day, const FileLocation& where) {
  try {
    const GpsTime time = CalendarToGpsTime(year, month, day, 0, 0, 0.0);
    return {kWeekS * static_cast<double>(time.week) + time.tow_s};
  } catch (const InvalidInput& error) {
    throw InvalidInput(error.what(), where);
  }
}

/// Returns the stamp of a valid RMC sentence. A receiver without a fix (status V) may state the
/// date of a clock that was never set.
std::optional<Stamp> ParseRmc(const std::vector<std::string_view>& fields,
                              const FileLocation& where) {
  if (!IsSentence(fields, "RMC", 10) || fields[2] != "A") return std::nullopt;
  if (fields[1].empty() || fields[9].size() != 6) return std::nullopt;
  const int short_year = TwoDigits(fields[9], 4);
  const int year = short_year + (short_year < 80 ? 2000 : 1900);
  return Stamp{MakeDay(year, TwoDigits(fields[9], 2), TwoDigits(fields[9], 0), where),
               DaySeconds(fields[1], where)};
}

std::optional<Stamp> ParseZda(const std::vector<std::string_view>& fields,
                              const FileLocation& where) {
  if (!IsSentence(fields, "ZDA", 5)) return std::nullopt;
  for (std::size_t i = 1; i <= 4; ++i) {
    if (fields[i].empty()) return std::nullopt;
  }
  const auto number = [&](std::size_t i) {
    return static_cast<int>(std::clamp(ParseNumber(fields[i], where), -1.0, 9999.0));
  };
  if (number(2) == 0 || number(3) == 0) return std::nullopt;  // a clock that was never set
  return Stamp{MakeDay(number(4), number(3), number(2), where), DaySeconds(fields[1], where)};
}

}  // namespace

void DateFinder::Take(const std::vector<std::string_view>& fields, bool after_first_fix,
                      const FileLocation& where) {
  if (const std::optional<Stamp> rmc = ParseRmc(fields, where)) {
    DayStamps& day = rmc_[rmc->day.t_s];
    if (day.count++ == 0) {
      day.first = *rmc;
      day.order = static_cast<long>(rmc_.size());
    }
  }
  if (zda_is_after_) return;
  if (const std::optional<Stamp> stamp = ParseZda(fields, where)) {
    zda_ = stamp;
    zda_is_after_ = after_first_fix;
  }
}

double DateFinder::MostFrequentDay() const {
  // A clock that was not set yet is in the past, so that the later one of two days counts.
  double day_s = 0.0;
  long most = 0;
  for (const auto& [begin_s, stamps] : rmc_) {
    if (stamps.count < most) continue;
    most = stamps.count;
    day_s = begin_s;
  }
  return day_s;
}

std::optional<Stamp> DateFinder::stamp() const {
  if (rmc_.empty()) return zda_;
  const double most_s = MostFrequentDay();
  const DayStamps* first = nullptr;
  for (const auto& [begin_s, stamps] : rmc_) {
    if (std::abs(begin_s - most_s) > kDayS) continue;
    if (first == nullptr || stamps.order < first->order) first = &stamps;
  }
  return first->first;
}

long DateFinder::outliers() const {
  long count = 0;
  for (const auto& [begin_s, stamps] : rmc_) {
    if (std::abs(begin_s - MostFrequentDay()) > kDayS) count += stamps.count;
  }
  return count;
}

bool MayHaveMissedARollover(const Stamp& stamp) {
  const double week = std::floor(stamp.day.t_s / kWeekS);
  return week >= 1024.0 && week < 1536.0;
}

}  // namespace dn::gnss_internal
