#include "date_column.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <initializer_list>

#include "lower_case.h"
#include "name_words.h"

namespace dn::files_internal {
namespace {

using Row = std::vector<std::string_view>;

constexpr int kMonths = 12;

/// Returns the number in front of a separator.
int FirstNumber(std::string_view date) { return std::atoi(std::string(date).c_str()); }

/// Returns the order of a date with separators. Only a number above 12 tells days from months.
std::optional<DateColumn> WithOrder(DateColumn column, std::string_view date) {
  if (DateSeconds(date, DateOrder::kYearFirst)) return column;
  const bool day_first = DateSeconds(date, DateOrder::kDayFirst).has_value(),
             month_first = DateSeconds(date, DateOrder::kMonthFirst).has_value();
  if (!day_first && !month_first) return std::nullopt;
  column.order = day_first ? DateOrder::kDayFirst : DateOrder::kMonthFirst;
  const std::size_t separator = date.find_first_not_of("0123456789");
  column.is_guess = day_first && month_first && FirstNumber(date) <= kMonths &&
                    FirstNumber(date) != FirstNumber(date.substr(separator + 1));
  return column;
}

bool HasWord(const std::string& name, std::initializer_list<std::string_view> choices) {
  const std::vector<std::string> words = SplitWords(LowerCase(name));
  return std::ranges::any_of(words, [&](const std::string& word) {
    return std::ranges::find(choices, word) != choices.end();
  });
}

std::optional<std::size_t> FindNamed(const std::vector<std::string>& names,
                                     std::initializer_list<std::string_view> words) {
  const auto found =
      std::ranges::find_if(names, [&](const std::string& name) { return HasWord(name, words); });
  return found == names.end() ? std::nullopt : std::optional<std::size_t>(found - names.begin());
}

bool IsWhole(double value) { return value > 0.0 && value < 1e8 && value == std::floor(value); }

}  // namespace

std::string DateColumn::Name() const {
  std::string name = is_gps ? "date_gps" : "date_utc";
  switch (order) {
    case DateOrder::kYearFirst:
      break;
    case DateOrder::kDayFirst:
      return name + "_dmy";
    case DateOrder::kMonthFirst:
      return name + "_mdy";
  }
  return name;
}

std::optional<double> DateColumn::Seconds(const Row& row) const {
  if (at >= row.size() || time >= row.size()) return std::nullopt;
  const auto day_s = DateSeconds(row[at], order), time_s = SecondsIntoDay(row[time]);
  return day_s && time_s ? std::optional(*day_s + *time_s) : std::nullopt;
}

std::optional<DateColumn> FindDateColumn(const Row& row) {
  const auto is_time = [&](std::size_t i) {
    return i < row.size() && row[i].find(':') != row[i].npos && SecondsIntoDay(row[i]);
  };
  for (std::size_t i = 0; i < row.size(); ++i) {
    const bool has_separators = std::ranges::count(row[i], '-') == 2 ||
                                std::ranges::count(row[i], '/') == 2 ||
                                std::ranges::count(row[i], '.') == 2;
    if (!has_separators || (!is_time(i + 1) && (i == 0 || !is_time(i - 1)))) continue;
    const auto found = WithOrder({.at = i, .time = is_time(i + 1) ? i + 1 : i - 1}, row[i]);
    if (found) return found;
  }
  return std::nullopt;
}

bool NamesGpsTime(const DateColumn& column, const std::vector<std::string>& names) {
  if (column.at >= names.size() || column.time >= names.size()) return false;
  bool gps = false;
  for (const std::size_t at : {column.at, column.time}) {
    const std::string name = LowerCase(names[at]);
    if (name.find("utc") != name.npos) return false;
    gps = gps || name.find("gps") != name.npos;
  }
  return gps;
}

std::optional<DateColumn> FindPlainDate(const std::vector<std::string>& names,
                                        const TextTable& table) {
  const auto date = FindNamed(names, {"date", "utcdate", "gpsdate"});
  auto time = FindNamed(names, {"time", "utctime", "gpstime", "hhmmss"});
  if (!time) time = FindNamed(names, {"utc"});
  if (!date || !time || date == time || table.rows() == 0) return std::nullopt;
  for (const DateOrder order : {DateOrder::kYearFirst, DateOrder::kDayFirst}) {
    // Six digits are those of NMEA, with the day first.
    const bool six = table.row(0)[*date] < 1e6;
    if (six && order == DateOrder::kYearFirst) continue;
    const DateColumn column{*date, *time, order, false};
    bool all = true;
    for (std::size_t i = 0; all && i < table.rows(); ++i) {
      all = PlainSeconds(column, table.row(i)).has_value();
    }
    if (all) return column;
  }
  return std::nullopt;
}

std::optional<double> PlainSeconds(const DateColumn& column, const double* row) {
  const double date = row[column.at], time = row[column.time];
  if (!IsWhole(date) || !(time >= 0.0 && time < 240000.0)) return std::nullopt;
  const auto day_s = DateSeconds(std::to_string(static_cast<long>(date)), column.order);
  const double whole = std::floor(time);
  const auto time_s = SecondsIntoDay(std::to_string(static_cast<long>(whole)));
  return day_s && time_s ? std::optional(*day_s + *time_s + (time - whole)) : std::nullopt;
}

}  // namespace dn::files_internal
