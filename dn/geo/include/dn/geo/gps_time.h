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

/// Returns GPS seconds since 1980-01-06 for a calendar time in UTC of ISO 8601, such as
/// "2023-09-21T09:49:42.02Z"; also with a blank instead of T, with slashes in the date, with an
/// offset such as +02:00 at the end, and without Z. Returns nullopt for any other text.
std::optional<double> CalendarSeconds(std::string_view text);

}  // namespace dn
