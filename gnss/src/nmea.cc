#include <dn/error.h>
#include <dn/geo/text_table.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gnss_readers.h"
#include "gps_time.h"

namespace dn::gnss_internal {
namespace {

/// Returns the fields of "$GPGGA,...*hh" without '$' and checksum. The result is empty for a line
/// that is not a sentence or has a wrong checksum.
std::vector<std::string_view> SplitSentence(std::string_view line) {
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
  if (line.empty() || line.front() != '$') return {};
  line.remove_prefix(1);
  const std::size_t star = line.find('*');
  if (star != std::string_view::npos) {
    unsigned sum = 0, stated = 256;
    for (const char c : line.substr(0, star)) sum ^= static_cast<unsigned char>(c);
    std::from_chars(line.data() + star + 1, line.data() + line.size(), stated, 16);
    if (sum != stated) return {};
    line = line.substr(0, star);
  }
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return fields;
}

bool IsSentence(const std::vector<std::string_view>& fields, std::string_view type,
                std::size_t least) {
  return fields.size() >= least && fields[0].size() == 5 && fields[0].substr(2) == type;
}

/// Parses two digits of a field from position `at` on; returns -1 if they are not digits.
int TwoDigits(std::string_view field, std::size_t at) {
  int value = -1;
  if (field.size() < at + 2) return -1;
  const char* end = field.data() + at + 2;
  const auto [parsed, error] = std::from_chars(field.data() + at, end, value);
  return error == std::errc() && parsed == end ? value : -1;
}

/// Parses "hhmmss.ss" and returns the seconds of the day.
double DaySeconds(std::string_view field, const FileLocation& where) {
  const int hour = TwoDigits(field, 0), minute = TwoDigits(field, 2);
  if (hour < 0 || hour > 23 || minute < 0 || minute > 59 || field.size() < 6) {
    throw InvalidInput("the time of an NMEA sentence is not hhmmss", where);
  }
  const double second = ParseNumber(field.substr(4), where);
  if (!(second >= 0.0 && second < 61.0)) {
    throw InvalidInput("the time of an NMEA sentence is not hhmmss", where);
  }
  return 3600.0 * hour + 60.0 * minute + second;
}

/// Converts "dddmm.mmmm" to degrees, negative for the hemispheres S and W.
double Degrees(std::string_view field, std::string_view hemisphere, const FileLocation& where) {
  const double value = ParseNumber(field, where);
  const double degrees = std::floor(value / 100.0);
  const double angle = degrees + (value - 100.0 * degrees) / 60.0;
  return hemisphere == "S" || hemisphere == "W" ? -angle : angle;
}

/// Beginning of a UTC day, written as if it were GPS time.
struct Day {
  double t_s;  ///< seconds since the GPS epoch
};

Day MakeDay(int year, int month, int day, const FileLocation& where) {
  try {
    const GpsTime time = CalendarToGpsTime(year, month, day, 0, 0, 0.0);
    return {kWeekS * static_cast<double>(time.week) + time.tow_s};
  } catch (const InvalidInput& error) {
    throw InvalidInput(error.what(), where);
  }
}

/// Date and time of day of one sentence, UTC.
struct Stamp {
  Day day;
  double time_of_day_s;
};

std::optional<Stamp> ParseStamp(const std::vector<std::string_view>& fields,
                                const FileLocation& where) {
  if (IsSentence(fields, "RMC", 10) && fields[9].size() == 6) {
    const int short_year = TwoDigits(fields[9], 4);
    const int year = short_year + (short_year < 80 ? 2000 : 1900);
    return Stamp{MakeDay(year, TwoDigits(fields[9], 2), TwoDigits(fields[9], 0), where),
                 DaySeconds(fields[1], where)};
  }
  if (IsSentence(fields, "ZDA", 5) && !fields[4].empty()) {
    const auto number = [&](std::size_t i) {
      return static_cast<int>(std::clamp(ParseNumber(fields[i], where), -1.0, 9999.0));
    };
    return Stamp{MakeDay(number(4), number(3), number(2), where), DaySeconds(fields[1], where)};
  }
  return std::nullopt;
}

struct Fix {
  double time_of_day_s;
  Geodetic antenna;
  long line;
};

/// Returns true if a GGA sentence contains a position.
bool HasFix(const std::vector<std::string_view>& gga) {
  return !gga[2].empty() && !gga[4].empty() && !gga[6].empty() && gga[6] != "0" && !gga[9].empty();
}

Fix ParseFix(const std::vector<std::string_view>& gga, const FileLocation& where) {
  Fix fix{};
  fix.time_of_day_s = DaySeconds(gga[1], where);
  const double separation_m = gga[11].empty() ? 0.0 : ParseNumber(gga[11], where);
  fix.antenna = {Degrees(gga[2], gga[3], where) * kRadPerDeg,
                 Degrees(gga[4], gga[5], where) * kRadPerDeg,
                 ParseNumber(gga[9], where) + separation_m};
  CheckGeodetic(fix.antenna, where);
  fix.line = where.line;
  return fix;
}

/// Returns the beginning of the day that puts `time_of_day_s` closest to `known_s`. The day differs
/// from `day_s` if the file crosses midnight.
double NearestDay(double day_s, double known_s, double time_of_day_s) {
  return day_s + kDayS * std::round((known_s - day_s - time_of_day_s) / kDayS);
}

GnssData MakeGnssData(const std::vector<Fix>& fixes, const Stamp& stamp, double time_offset_s,
                      const std::filesystem::path& file) {
  TextTable table;
  table.file = file;
  table.columns = 4;
  double utc_s = stamp.day.t_s + stamp.time_of_day_s, week_s = -1.0;
  for (const Fix& fix : fixes) {
    utc_s = NearestDay(stamp.day.t_s, utc_s, fix.time_of_day_s) + fix.time_of_day_s;
    const double week = std::floor(utc_s / kWeekS);
    const GpsTime utc{static_cast<long>(week), utc_s - kWeekS * week};
    const double t_s = utc_s + GpsMinusUtcS(utc);
    if (week_s < 0.0) week_s = kWeekS * std::floor(t_s / kWeekS);
    table.values.insert(table.values.end(),
                        {t_s - week_s, fix.antenna.lat_rad, fix.antenna.lon_rad, fix.antenna.h_m});
    table.lines.push_back(fix.line);
  }
  GnssData data;
  std::vector<std::size_t> keep;
  data.repeated_rows_dropped = ContinueAndCheckTimes(table, keep, time_offset_s);
  for (const std::size_t i : keep) {
    GnssEpoch epoch;
    epoch.t_s = table.row(i)[0];
    epoch.antenna = fixes[i].antenna;
    epoch.line = fixes[i].line;
    data.epochs.push_back(epoch);
  }
  return data;
}

}  // namespace

GnssData ReadNmea(const std::filesystem::path& file, double time_offset_s) {
  std::vector<Fix> fixes;
  std::optional<Stamp> stamp;
  long unusable = 0;
  LineReader lines(file);
  for (std::string_view line; lines.Next(&line);) {
    const FileLocation where{file.string(), lines.line(), 0};
    const std::vector<std::string_view> fields = SplitSentence(line);
    if (!stamp) stamp = ParseStamp(fields, where);
    if (fields.empty() && line.find("GGA") != std::string_view::npos) ++unusable;
    if (!IsSentence(fields, "GGA", 12)) continue;
    if (HasFix(fields)) {
      fixes.push_back(ParseFix(fields, where));
    } else {
      ++unusable;
    }
  }
  if (fixes.empty()) throw InvalidInput("no GGA sentence with a position", {file.string(), 0, 0});
  if (!stamp) {
    throw InvalidInput("no RMC or ZDA sentence gives the date of the GGA sentences",
                       {file.string(), 0, 0});
  }
  GnssData data = MakeGnssData(fixes, *stamp, time_offset_s, file);
  data.unusable_sentences = unusable;
  return data;
}

}  // namespace dn::gnss_internal
