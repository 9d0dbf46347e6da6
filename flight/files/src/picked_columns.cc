#include "picked_columns.h"

#include <dn/geo/gps_time.h>
#include <dn/median.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "content_fit.h"
#include "lower_case.h"

namespace dn::files_internal {
namespace {

constexpr const char* kTimeOfDay = "time_of_day";

struct TimeUnit {
  const char* name;
  double seconds;
};
// The units in front are those that the steps may decide on.
constexpr std::array<TimeUnit, 8> kTimeUnits{{{"t", 1.0},
                                              {"t_ms", 1e-3},
                                              {"t_us", 1e-6},
                                              {"t_ns", 1e-9},
                                              {"t_min", 60.0},
                                              {"t_100us", 1e-4},
                                              {"t_utc", 1.0},
                                              {kTimeOfDay, 1.0}}};
constexpr std::ptrdiff_t kUnitsBySteps = 4;

constexpr double kNanosecond = 1e-9;

// The share of the steps that must be positive; the others are repeated rows.
constexpr double kLeastIncreasing = 0.9;

double UnitSeconds(const std::string& name) {
  return std::find_if(kTimeUnits.begin(), kTimeUnits.end(),
                      [&](const TimeUnit& unit) { return unit.name == name; })
      ->seconds;
}

std::vector<double> Times(const TextSample& sample, const TimeColumn& time) {
  std::vector<double> times;
  for (const double value : PickRows(sample, time, {}).values) times.push_back(value);
  return times;
}

/// Sets the unit by the size of the steps. Returns false if no unit fits, or if the time does not
/// increase.
bool FindUnit(const TextSample& sample, const StepRange& range, bool unit_is_named,
              TimeColumn* time) {
  if (time->at < sample.first_row.size() && CalendarSeconds(sample.first_row[time->at])) {
    time->name = "t_utc";
    unit_is_named = true;
  }
  const std::vector<double> times = Times(sample, *time);
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] > times[i - 1]) steps.push_back(times[i] - times[i - 1]);
  }
  if (steps.empty() || static_cast<double>(steps.size()) <
                           kLeastIncreasing * static_cast<double>(times.size() - 1)) {
    return false;
  }
  const double step = Median(steps);
  const auto plausible = [&](double step_s) {
    return step_s >= range.least_s && step_s <= range.most_s;
  };
  if (unit_is_named) return plausible(step);
  // The steps of several units may be plausible, and give valid times or not.
  const auto rank = [&](const TimeUnit& unit) {
    const double unusual = std::abs(std::log(step * unit.seconds / range.usual_s));
    return std::pair(!IsTime(times.front() * unit.seconds), unit.seconds == 1.0 ? 0.0 : unusual);
  };
  const TimeUnit* best = nullptr;
  std::for_each(kTimeUnits.begin(), kTimeUnits.begin() + kUnitsBySteps, [&](const TimeUnit& unit) {
    if (!plausible(step * unit.seconds)) return;
    if (best == nullptr || rank(unit) < rank(*best)) best = &unit;
  });
  if (best != nullptr) time->name = best->name;
  return best != nullptr;
}

/// Sets the unit of a SampleTimeFine: 0.1 ms in the exports of MT Manager, us in those of small
/// sensors, whose rates are below 400 Hz.
void SetSampleTimeUnit(const TextSample& sample, TimeColumn* time) {
  constexpr double kLeastStepUs = 2500.0;
  const double step = MedianTimeStep(PickRows(sample, *time, {}));
  time->name = step < kLeastStepUs ? "t_100us" : "t_us";
}

bool IsSampleTime(const std::string& name) { return LowerCase(name) == "sampletimefine"; }

/// Returns whether all values are nanoseconds within a second.
bool AreNanoseconds(const TextTable& table, std::size_t at) {
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double value = table.row(i)[at];
    if (!(value >= 0.0 && value < 1.0 / kNanosecond)) return false;
  }
  return true;
}

/// Returns whether a time is the stamp of a sensor, not the time of recording.
bool IsStamp(const std::string& name) {
  const std::size_t at = name.find("stamp");
  return at != name.npos &&
         (at == 0 || std::string_view("._ ").find(name[at - 1]) != std::string_view::npos);
}

/// Returns 0 for the stamp of a sensor, 1 for GPS time, and 2 for other times.
int TimeRank(const std::string& name) {
  if (IsStamp(name)) return 0;
  const std::string lower = LowerCase(name);
  return lower.find("gps") != name.npos || lower.find("tow") != name.npos ? 1 : 2;
}

/// Returns the columns with a time in their name, stamps first: whole seconds with nanoseconds,
/// then single columns.
std::vector<TimeColumn> NamedTimes(const TextSample& sample,
                                   const std::vector<ColumnMeaning>& meanings) {
  std::vector<TimeColumn> times;
  for (const int rank : {0, 1, 2}) {
    for (std::size_t i = 0; i < meanings.size(); ++i) {
      if (!meanings[i].name.starts_with("t") || TimeRank(sample.names[i]) != rank) continue;
      const bool pair = meanings[i].name == "t" && i + 1 < meanings.size() &&
                        meanings[i + 1].name == "t_ns" && AreNanoseconds(sample.table, i + 1);
      if (pair) times.push_back({i, {}, "t", i + 1});
      times.push_back({i, {}, meanings[i].name});
    }
  }
  return times;
}

/// Returns whether a time is a stamp or GPS time, and not the time of day of the date.
bool IsBetterThanDate(const TextSample& sample, const TimeColumn& time) {
  return time.at != sample.date->time && TimeRank(sample.names[time.at]) < 2;
}

}  // namespace

bool IsWeek(const TextTable& table, std::size_t at) {
  constexpr double kFirstWeek = 500.0, kLastWeek = 4000.0;
  const double first = table.row(0)[at];
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double week = table.row(i)[at];
    if (week != std::floor(week) || week < kFirstWeek || week > kLastWeek) return false;
    if (week != first && week != first + 1.0) return false;
  }
  return true;
}

std::vector<ColumnMeaning> FindMeanings(const TextSample& sample) {
  std::vector<ColumnMeaning> meanings;
  for (const std::string& name : sample.names) meanings.push_back(FindMeaning(name));
  for (std::size_t i = 0; i + 3 <= meanings.size(); ++i) {
    ColumnMeaning* three = &meanings[i];
    if (three[0].index < 0 || three[0].index > 1) continue;
    const bool follow = std::all_of(three + 1, three + 3, [&](const ColumnMeaning& each) {
      return each.name == three[0].name && each.sensor == three[0].sensor &&
             each.index == three[0].index + (&each - three);
    });
    for (std::size_t k = 0; follow && k < 3; ++k) three[k].name += "xyz"[k];
  }
  return meanings;
}

bool IsUnnamed(const std::vector<ColumnMeaning>& meanings, std::size_t at) {
  if (at >= meanings.size()) return true;
  const std::string& name = meanings[at].name;
  return name.empty() || name == kRate || name == kForce;
}

bool NamesInertialData(const std::vector<ColumnMeaning>& meanings) {
  const auto has = [&](const char* name) { return FindColumn(meanings, name).has_value(); };
  return (has("wx") || has("wy") || has("wz")) && (has("fx") || has("fy") || has("fz"));
}

std::optional<NamedColumn> FindColumn(const std::vector<ColumnMeaning>& meanings,
                                      const std::string& name) {
  for (std::size_t i = 0; i < meanings.size(); ++i) {
    if (meanings[i].name == name) return NamedColumn{name, i};
  }
  return std::nullopt;
}

std::vector<NamedColumn> FindMinutes(const std::vector<ColumnMeaning>& meanings) {
  std::vector<NamedColumn> added;
  for (const char* name : {"lat_min", "lat_sec", "lon_min", "lon_sec"}) {
    if (const auto column = FindColumn(meanings, name)) added.push_back(*column);
  }
  return added;
}

std::optional<TimeColumn> FindTime(const TextSample& sample, const StepRange& steps) {
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  const auto week = FindColumn(meanings, "week");
  for (TimeColumn& time : NamedTimes(sample, meanings)) {
    if (sample.date && !IsBetterThanDate(sample, time)) continue;
    if (week) time.week = week->at;
    const bool is_sample_time = IsSampleTime(sample.names[time.at]);
    if (is_sample_time) SetSampleTimeUnit(sample, &time);
    const bool unit_is_named =
        !meanings[time.at].unit.empty() || time.name != "t" || is_sample_time;
    if (FindUnit(sample, steps, unit_is_named, &time)) return time;
  }
  if (sample.date) {
    TimeColumn time{.at = sample.date->time, .name = kTimeOfDay, .date = sample.date};
    return FindUnit(sample, steps, true, &time) ? std::optional(time) : std::nullopt;
  }
  std::vector<TimeColumn> candidates{{0, {}}};
  if (sample.table.columns > 2 && sample.table.rows() > 1) {
    if (IsWeek(sample.table, 0)) candidates.insert(candidates.begin(), {1, 0});
    if (IsWeek(sample.table, 1)) candidates.insert(candidates.begin(), {0, 1});
  }
  for (TimeColumn& time : candidates) {
    if (IsUnnamed(meanings, time.at) && FindUnit(sample, steps, false, &time)) return time;
  }
  return std::nullopt;
}

TextTable PickRows(const TextSample& sample, const TimeColumn& time,
                   const std::vector<NamedColumn>& columns) {
  TextTable picked;
  picked.file = sample.table.file;
  picked.columns = 1 + columns.size();
  std::vector<double> values;
  for (std::size_t i = 0; i < sample.table.rows(); ++i) {
    const double* row = sample.table.row(i);
    values.assign(1, row[time.at] * UnitSeconds(time.name));
    if (time.nanoseconds) values[0] += kNanosecond * row[*time.nanoseconds];
    if (time.week) values[0] += kWeekS * (row[*time.week] - sample.table.row(0)[*time.week]);
    for (const NamedColumn& column : columns) values.push_back(row[column.at]);
    if (!std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); }))
      continue;
    picked.values.insert(picked.values.end(), values.begin(), values.end());
    picked.lines.push_back(sample.table.lines[i]);
  }
  return picked;
}

bool AreNumbers(const TextTable& picked, const TextSample& sample) {
  constexpr double kLeastShare = 0.9;
  return picked.rows() > 0 && static_cast<double>(picked.rows()) >=
                                  kLeastShare * static_cast<double>(sample.table.rows());
}

ColumnNames FormatNames(const TimeColumn& time, const std::vector<NamedColumn>& columns) {
  std::vector<NamedColumn> all = columns;
  all.push_back({time.name, time.at});
  if (time.week) all.push_back({"week", *time.week});
  if (time.nanoseconds) all.push_back({"nsec", *time.nanoseconds});
  if (time.date) all.push_back({time.date->Name(), time.date->at});
  std::size_t last = 0;
  for (const NamedColumn& column : all) last = std::max(last, column.at);
  ColumnNames names(last + 1, "skip");
  for (const NamedColumn& column : all) names[column.at] = column.name;
  return names;
}

double MedianTimeStep(const TextTable& table) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < table.rows(); ++i) {
    const double step = table.row(i)[0] - table.row(i - 1)[0];
    if (step > 0.0) steps.push_back(step);
  }
  return steps.empty() ? 0.0 : Median(steps);
}

}  // namespace dn::files_internal
