#pragma once

namespace dn::internal {

inline constexpr double kDayS = 86400.0;

/// A GPS time: week since 1980-01-06 and seconds of it.
struct GpsTime {
  long week = 0;
  double tow_s = 0.0;
};

/// GPS time of a calendar date and time of day, both in GPS time. Throws InvalidInput (without a
/// location) when there is no such date or time of day, or it is before the GPS epoch.
GpsTime GpsTimeOfCalendar(int year, int month, int day, int hour, int minute, double second);

/// GPS time minus UTC, s (leap seconds), at a UTC time given as if it were GPS time. The last leap
/// second known is that of 2017-01-01.
int GpsMinusUtcS(const GpsTime& utc);

}  // namespace dn::internal
