#include <dn/error.h>
#include <dn/geo/gps_time.h>

#include <array>
#include <chrono>
#include <string>

namespace dn {
namespace {

using std::chrono::day;
using std::chrono::month;
using std::chrono::sys_days;
using std::chrono::year;
using std::chrono::year_month_day;

constexpr sys_days kGpsEpoch = year{1980} / 1 / 6;

/// Days on which GPS time minus UTC grew by one second (IERS Bulletin C).
constexpr std::array<year_month_day, 18> kLeapDays{
    year{1981} / 7 / 1, year{1982} / 7 / 1, year{1983} / 7 / 1, year{1985} / 7 / 1,
    year{1988} / 1 / 1, year{1990} / 1 / 1, year{1991} / 1 / 1, year{1992} / 7 / 1,
    year{1993} / 7 / 1, year{1994} / 7 / 1, year{1996} / 1 / 1, year{1997} / 7 / 1,
    year{1999} / 1 / 1, year{2006} / 1 / 1, year{2009} / 1 / 1, year{2012} / 7 / 1,
    year{2015} / 7 / 1, year{2017} / 1 / 1};

}  // namespace

GpsTime CalendarToGpsTime(int y, int m, int d, int hour, int minute, double second) {
  const year_month_day date{year{y}, month{static_cast<unsigned>(m)},
                            day{static_cast<unsigned>(d)}};
  if (!date.ok()) throw InvalidInput("there is no such date");
  if (hour < 0 || hour > 23 || minute < 0 || minute > 59 || !(second >= 0.0 && second < 61.0)) {
    throw InvalidInput("there is no such time of day");
  }
  const long days = (sys_days{date} - kGpsEpoch).count();
  if (days < 0) throw InvalidInput("date is before the GPS epoch, 1980/01/06");
  const double second_of_day = 3600.0 * hour + 60.0 * minute + second;
  return {days / 7, kDayS * static_cast<double>(days % 7) + second_of_day};
}

int GpsMinusUtcS(const GpsTime& utc) {
  int count = 0;
  for (const year_month_day& leap_day : kLeapDays) {
    const long days = (sys_days{leap_day} - kGpsEpoch).count();
    const double since_s =
        7.0 * kDayS * static_cast<double>(utc.week) + utc.tow_s - kDayS * static_cast<double>(days);
    if (since_s >= 0.0) ++count;
  }
  return count;
}

}  // namespace dn
