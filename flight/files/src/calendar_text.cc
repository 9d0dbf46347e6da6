#include "calendar_text.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "lower_case.h"

namespace dn::files_internal {
namespace {

std::string NameOrNumber(const TextSample& sample, std::size_t at) {
  return at < sample.names.size() ? "'" + sample.names[at] + "'" : std::to_string(at + 1);
}

/// Returns whether most values of a column are not numbers.
bool IsText(const TextSample& sample, std::size_t at) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < sample.table.rows(); ++i) {
    if (std::isnan(sample.table.row(i)[at])) ++count;
  }
  return 2 * count > sample.table.rows();
}

/// Returns whether at least a tenth of the values repeat the one before, and others do not.
bool StandsStill(const TextTable& table, std::size_t at) {
  std::size_t same = 0, more = 0;
  for (std::size_t i = 1; i < table.rows(); ++i) {
    const double step = table.row(i)[at] - table.row(i - 1)[at];
    if (step == 0.0) ++same;
    if (step > 0.0) ++more;
  }
  return more > 0 && 10 * same >= table.rows();
}

}  // namespace

bool IsCalendarText(std::string_view text) {
  const bool digits = std::all_of(text.begin(), text.end(), [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("-/:. TZ+").find(c) != std::string_view::npos;
  });
  if (!digits || text.empty() || std::isdigit(static_cast<unsigned char>(text[0])) == 0)
    return false;
  for (const char separator : {'-', '/', ':'}) {
    if (std::count(text.begin(), text.end(), separator) == 2) return true;
  }
  return std::count(text.begin(), text.end(), '.') == 2;
}

std::string CalendarAdvice(std::string_view column, std::string_view text) {
  return "the times are calendar times in column " + std::string(column) + " ('" +
         std::string(text) +
         "'): write GPS seconds, UTC as 2023-09-21T09:49:42.00Z, or a date and the time of day in "
         "two columns";
}

std::string DateNote(const TextSample& sample) {
  if (!sample.date || !sample.date->is_guess) return {};
  return "the date '" + sample.first_row[sample.date->at] +
         "' is read with the day first; if the month is first, name its column date_utc_mdy";
}

std::string TimeReason(const TextSample& sample, const std::string& steps) {
  const std::size_t columns =
      sample.date ? 0 : std::min(sample.table.columns, sample.first_row.size());
  for (std::size_t at = 0; at < columns; ++at) {
    if (IsText(sample, at) && IsCalendarText(sample.first_row[at])) {
      return CalendarAdvice(NameOrNumber(sample, at), sample.first_row[at]);
    }
  }
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  for (const char* name : {"t", "t_ms", "t_us", "t_ns"}) {
    const auto time = FindColumn(meanings, name);
    if (time && sample.table.rows() > 1 && StandsStill(sample.table, time->at)) {
      return "the time " + NameOrNumber(sample, time->at) +
             " is the same in several rows: give one row for each time";
    }
  }
  return "no time that increases " + steps;
}

std::string TextReason(const TextSample& sample, const std::vector<NamedColumn>& columns) {
  for (const NamedColumn& column : columns) {
    if (column.at >= sample.first_row.size() || !IsText(sample, column.at)) continue;
    return "column " + NameOrNumber(sample, column.at) + " contains text, such as '" +
           sample.first_row[column.at] + "'";
  }
  return "the columns contain text";
}

}  // namespace dn::files_internal
