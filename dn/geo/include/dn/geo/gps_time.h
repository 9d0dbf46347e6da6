#pragma once

#include <optional>
#include <string_view>

namespace dn {

inline constexpr double kDayS = 86400.0;

/// GPS time: weeks since 1980-01-06 and seconds of the week.
struct GpsTime {
  long week = 0;
  double tow_s = 0.0;
};

/// Converts a calendar date and time of day, both in GPS time. Throws InvalidInput (without a
/// location) for a date or time of day that does not exist, and for a date before the GPS epoch.
GpsTime CalendarToGpsTime(int year, int month, int day, int hour, int minute, double second);

/// Returns GPS time minus UTC, s (leap seconds), at a UTC time that is stored as if it were GPS
/// time. The last known leap second is that of 2017-01-01.
int GpsMinusUtcS(const GpsTime& utc);

/// Order of the numbers in a date.
enum class DateOrder { kYearFirst, kDayFirst, kMonthFirst };

/// Returns GPS seconds since 1980-01-06 at the beginning of a day in UTC. The date has dashes,
/// slashes or dots, as in "2023-09-21" or "9/21/2023", or two digits for each number, as in
/// "20230921" and "210923", whose first zero may be missing. The day is first in a date with dots
/// and the year at its end, whatever the order. Returns nullopt for any other text, and for a date
/// that does not exist.
std::optional<double> DateSeconds(std::string_view text, DateOrder order);

/// Returns the seconds of a time of day such as "09:49:42.02" or "094942.02". Zeros at the
/// beginning may be missing. Returns nullopt for any other text.
std::optional<double> SecondsIntoDay(std::string_view text);

/// Returns GPS seconds since 1980-01-06 for a calendar time in UTC of ISO 8601, such as
/// "2023-09-21T09:49:42.02Z"; also with a blank instead of T, with slashes in the date, as
/// "21.09.2023 09:49:42", with an offset such as +02:00 at the end, and without Z. Returns nullopt
/// for any other text.
std::optional<double> CalendarSeconds(std::string_view text);

}  // namespace dn
