#include <dn/error.h>
#include <dn/geo/gps_time.h>
#include <dn/geo/text_table.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gnss_readers.h"
#include "nmea_date.h"
#include "nmea_sentence.h"

namespace dn::gnss_internal {
namespace {

struct Fix {
  double time_of_day_s;
  Geodetic antenna;
  long line;
  std::string talker;
  bool has_separation;
  int quality;  ///< as in RTKLIB
};

/// Converts the quality of a GGA sentence to that of RTKLIB. Values without meaning become 0.
int RtklibQuality(std::string_view quality) {
  constexpr std::string_view kGga = "12345";
  constexpr std::array<int, 5> kRtklib{5, 4, 5, 1, 2};
  const std::size_t at = quality.size() == 1 ? kGga.find(quality[0]) : kGga.npos;
  return at == kGga.npos ? 0 : kRtklib[at];
}

/// Returns true if a GGA sentence contains a position.
bool HasFix(const std::vector<std::string_view>& gga) {
  return !gga[1].empty() && !gga[2].empty() && !gga[4].empty() && !gga[6].empty() &&
         gga[6] != "0" && !gga[9].empty();
}

/// Returns true if the position is measured: not dead reckoning (6), manual (7) or simulated (8).
bool IsMeasured(const std::vector<std::string_view>& gga) {
  return gga[6] != "6" && gga[6] != "7" && gga[6] != "8";
}

Fix ParseFix(const std::vector<std::string_view>& gga, const FileLocation& where) {
  Fix fix{};
  fix.time_of_day_s = DaySeconds(gga[1], where);
  fix.has_separation = !gga[11].empty();
  const double separation_m = fix.has_separation ? ParseNumber(gga[11], where) : 0.0;
  fix.antenna = {Degrees(gga[2], gga[3], 'N', 'S', where) * kRadPerDeg,
                 Degrees(gga[4], gga[5], 'E', 'W', where) * kRadPerDeg,
                 ParseNumber(gga[9], where) + separation_m};
  CheckGeodetic(fix.antenna, where);
  fix.line = where.line;
  fix.talker = gga[0].substr(0, 2);
  fix.quality = RtklibQuality(gga[6]);
  return fix;
}

/// Keeps the sentences of one talker: GN, which combines all systems, unless another one is more
/// than twice as frequent. The positions of other talkers are further solutions at the same epochs.
long KeepOneTalker(std::vector<Fix>* fixes) {
  std::map<std::string, long> count;
  for (const Fix& fix : *fixes) ++count[fix.talker];
  const auto best = std::max_element(count.begin(), count.end(), [](const auto& a, const auto& b) {
    const auto rank = [](const auto& talker) {
      const bool combined = talker.first == "GN";
      return std::pair(combined ? 2 * talker.second : talker.second, combined);
    };
    return rank(a) < rank(b);
  });
  if (best == count.end()) return 0;
  return static_cast<long>(
      std::erase_if(*fixes, [&](const Fix& fix) { return fix.talker != best->first; }));
}

/// Removes positions whose ellipsoidal height is unknown. Throws InvalidInput if it is never known.
long KeepEllipsoidalHeights(const std::filesystem::path& file, std::vector<Fix>* fixes) {
  const long first = fixes->empty() ? 0 : fixes->front().line;
  const auto removed = std::erase_if(*fixes, [](const Fix& fix) { return !fix.has_separation; });
  if (fixes->empty() && removed > 0) {
    throw InvalidInput(
        "no GGA sentence states the geoid separation (field 11), so the heights above the "
        "ellipsoid "
        "are unknown; let the receiver write it, or give a table of t, latitude, longitude and "
        "ellipsoidal height (format odyn)",
        {file.string(), first, 0});
  }
  return static_cast<long>(removed);
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
    epoch.quality = fixes[i].quality;
    data.epochs.push_back(epoch);
  }
  return data;
}

std::string NoPositions(long not_measured) {
  if (not_measured == 0) return "no GGA sentence with a position";
  return "all " + std::to_string(not_measured) +
         " positions have quality 6, 7 or 8, which is dead reckoning, manual or simulated: none is "
         "measured; log the solution of the GNSS receiver";
}

}  // namespace

GnssData ReadNmea(const std::filesystem::path& file, double time_offset_s) {
  std::vector<Fix> fixes;
  DateFinder date;
  long unusable = 0, not_measured = 0;
  LineReader lines(file);
  for (std::string_view line; lines.Next(&line);) {
    const FileLocation where{file.string(), lines.line(), 0};
    const std::vector<std::string_view> fields = SplitSentence(line);
    date.Take(fields, !fixes.empty(), where);
    if (fields.empty() && line.find("GGA") != std::string_view::npos) ++unusable;
    if (!IsSentence(fields, "GGA", 12)) continue;
    if (!HasFix(fields)) {
      ++unusable;
    } else if (!IsMeasured(fields)) {
      ++not_measured;
    } else {
      fixes.push_back(ParseFix(fields, where));
    }
  }
  const long other_talkers = KeepOneTalker(&fixes);
  const long without_separation = KeepEllipsoidalHeights(file, &fixes);
  if (fixes.empty()) throw InvalidInput(NoPositions(not_measured), {file.string(), 0, 0});
  const std::optional<Stamp> stamp = date.stamp();
  if (!stamp) {
    throw InvalidInput("no valid RMC or ZDA sentence gives the date of the GGA sentences",
                       {file.string(), 0, 0});
  }
  GnssData data = MakeGnssData(fixes, *stamp, time_offset_s, file);
  data.unusable_sentences = unusable;
  data.Count("gnss positions of dead reckoning, manual or simulated, left out", not_measured);
  data.Count("gnss sentences of another talker, left out", other_talkers);
  data.Count("gnss dates that differ from the others by more than a day, left out",
             date.outliers());
  data.Count("gnss sentences without geoid separation, left out", without_separation);
  if (MayHaveMissedARollover(*stamp)) {
    data.Count(
        "gnss sentences dated 1999 to 2009: if the receiver missed a rollover of 1024 weeks, "
        "their leap seconds are those of the wrong date, and gnss.time_offset_s corrects it",
        static_cast<long>(fixes.size()));
  }
  return data;
}

}  // namespace dn::gnss_internal
