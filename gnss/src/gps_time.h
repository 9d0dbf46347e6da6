#pragma once

namespace dn::gnss_internal {

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

}  // namespace dn::gnss_internal
