#include <dn/geo/gps_time.h>
#include <dn/geo/named_columns.h>
#include <dn/geo/text_fields.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "column_layout.h"

namespace dn {
namespace {

using geo_internal::ColumnForm;
using geo_internal::ColumnLayout;
using Fields = std::vector<std::string_view>;

std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// Converts dddmm.mmmm to degrees.
double DegreesFromMinutes(double value) {
  const double degrees = std::floor(std::abs(value) / 100.0);
  return std::copysign(degrees + (std::abs(value) - 100.0 * degrees) / 60.0, value);
}

/// Returns whether a field has no value: it is empty, or a word that says so.
bool IsEmptyField(std::string_view field) {
  std::string lower(field);
  std::ranges::transform(lower, lower.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::array<std::string_view, 7> kWords{"", "nan", "null", "none", "na", "n/a", "-"};
  return std::ranges::find(kWords, lower) != kWords.end();
}

const char* LeadingPart(DateOrder order) {
  switch (order) {
    case DateOrder::kYearFirst:
      return "year";
    case DateOrder::kDayFirst:
      return "day";
    case DateOrder::kMonthFirst:
      break;
  }
  return "month";
}

/// Appends the used values of lines to a table.
class NamedRows {
 public:
  NamedRows(const ColumnLayout& layout, EmptyRows empty, TextTable* table)
      : layout_(layout), empty_(empty), table_(*table) {}

  void Take(std::string_view line, long number) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return;
    const bool comment = line[begin] == '#' || line[begin] == '%';
    if (comment && !layout_.has_messages()) return;
    line_ = line;
    number_ = number;
    fields_ = layout_.has_messages() ? SplitMessage(line) : SplitFields(line);
    if (!layout_.Accepts(fields_)) return;
    if (empty_ == EmptyRows::kLeaveOut && IsEmptyRow()) return;
    const std::size_t time = layout_.places().front();
    const bool has_time = time < fields_.size() && HasTime(fields_[time]);
    const bool short_row = fields_.size() < layout_.least_fields();
    if (table_.lines.empty() && (!has_time || short_row)) return;  // a line of the header
    if (short_row) {
      throw InvalidInput("row has " + std::to_string(fields_.size()) +
                             " columns, but `columns` names " +
                             std::to_string(layout_.least_fields()),
                         {table_.file.string(), number, 0});
    }
    AppendRow();
  }

 private:
  /// Returns whether all quantities after the time are missing.
  bool IsEmptyRow() const {
    const std::vector<std::size_t>& places = layout_.places();
    return std::all_of(places.begin() + 1, places.end(), [&](std::size_t place) {
      return place >= fields_.size() || IsEmptyField(fields_[place]);
    });
  }

  bool HasTime(std::string_view field) const {
    const ColumnForm form = layout_.form(layout_.places().front());
    if (form == ColumnForm::kCalendarTime) return CalendarSeconds(field).has_value();
    if (form == ColumnForm::kTimeOfDay) return SecondsIntoDay(field).has_value();
    return FieldNumber(field).has_value();
  }

  void AppendRow() {
    const std::size_t begin = table_.values.size();
    for (const std::size_t place : layout_.places()) {
      table_.values.push_back(layout_.factor(place) * Value(place));
    }
    table_.lines.push_back(number_);
    double* row = table_.values.data() + begin;
    for (const ColumnLayout::AddedPlace& each : layout_.added()) {
      if (!each.addend->hemispheres.empty()) continue;
      row[each.column] +=
          each.addend->date ? Day(each) : Sign(each) * each.addend->factor * Value(each.place);
    }
    for (const ColumnLayout::AddedPlace& each : layout_.added()) {
      if (!each.addend->hemispheres.empty()) TakeHemisphere(each, row + each.column);
    }
    if (layout_.week()) row[0] += WeeksS(Value(*layout_.week()));
  }

  FileLocation Where(std::size_t place) const {
    return {table_.file.string(), number_,
            static_cast<long>(fields_[place].data() - line_.data()) + 1};
  }

  double Value(std::size_t place) const {
    const std::string_view field = fields_[place];
    const ColumnForm form = layout_.form(place);
    if (form == ColumnForm::kCalendarTime) {
      if (const std::optional<double> seconds = CalendarSeconds(field)) return *seconds;
      throw InvalidInput("'" + std::string(field) + "' is not a calendar time yyyy-mm-ddThh:mm:ss",
                         Where(place));
    }
    if (form == ColumnForm::kTimeOfDay) {
      if (const std::optional<double> seconds = SecondsIntoDay(field)) return *seconds;
      throw InvalidInput("'" + std::string(field) + "' is not a time of day hh:mm:ss",
                         Where(place));
    }
    const double value = ParseNumber(field, Where(place));
    if (form == ColumnForm::kDegreesMinutes) return DegreesFromMinutes(value);
    if (form != ColumnForm::kVariance) return value;
    if (value < 0.0) throw InvalidInput("the variance is negative", Where(place));
    return std::sqrt(value);
  }

  /// Returns the beginning of a day, GPS seconds since 1980.
  double Day(const ColumnLayout::AddedPlace& added) const {
    const std::string_view field = fields_[added.place];
    if (const std::optional<double> day_s = DateSeconds(field, *added.addend->date)) {
      return *day_s - (added.addend->is_gps ? GpsMinusUtcS({0, *day_s}) : 0);
    }
    throw InvalidInput("'" + std::string(field) + "' is not a date with the " +
                           LeadingPart(*added.addend->date) + " first",
                       Where(added.place));
  }

  /// Gives an angle the sign of its hemisphere.
  void TakeHemisphere(const ColumnLayout::AddedPlace& added, double* angle) const {
    const std::string_view field = fields_[added.place], letters = added.addend->hemispheres;
    const char letter =
        field.empty() ? ' ' : static_cast<char>(std::toupper(static_cast<unsigned char>(field[0])));
    const std::size_t found = letters.find(letter);
    if (field.size() != 1 || found == letters.npos) {
      throw InvalidInput(
          "'" + std::string(field) + "' is not a hemisphere " + letters[0] + " or " + letters[1],
          Where(added.place));
    }
    if (*angle < 0.0) {
      throw InvalidInput("the angle has a sign and a hemisphere", Where(added.place));
    }
    if (found == 1) *angle = -*angle;
  }

  // The degrees of "-0 30 0" have a sign but no size.
  double Sign(const ColumnLayout::AddedPlace& added) const {
    if (!added.addend->has_sign_of_column) return 1.0;
    const std::size_t place = layout_.places()[added.column];
    return (fields_[place].starts_with('-') ? -1.0 : 1.0) * layout_.factor(place);
  }

  double WeeksS(double week) {
    if (table_.lines.size() == 1) first_week_ = week;
    return kWeekS * (week - first_week_);
  }

  const ColumnLayout& layout_;
  EmptyRows empty_;
  TextTable& table_;
  std::string_view line_;
  long number_ = 0;
  Fields fields_;
  double first_week_ = 0.0;
};

/// Returns whether a name is one of the quantities, or one that is added to them.
bool IsKnown(const std::string& name, const std::vector<std::string>& quantities) {
  const auto has = [&](std::string_view quantity) {
    return quantity == "t" ||
           std::find(quantities.begin(), quantities.end(), quantity) != quantities.end();
  };
  const geo_internal::Addend* addend = geo_internal::FindAddend(name);
  return name == "week" || has(name) || (addend != nullptr && has(addend->quantity));
}

}  // namespace

bool HasColumn(const ColumnNames& names, const std::string& quantity) {
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    const auto given = geo_internal::GivenQuantities(geo_internal::ParseColumnName(name).quantity);
    return std::find(given.begin(), given.end(), quantity) != given.end();
  });
}

std::string FormatColumnNames(const ColumnNames& names) { return "[" + Listed(names) + "]"; }

void CheckColumnNames(const ColumnNames& names, const std::vector<std::string>& quantities) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    const std::string column = geo_internal::ParseColumnName(name).quantity;
    if (column == "skip" || geo_internal::IsCondition(column)) continue;
    for (const std::string& quantity : geo_internal::GivenQuantities(column)) {
      if (!IsKnown(quantity, quantities)) {
        throw InvalidInput("'" + name +
                           "' is not a column; the columns are t (t_min, t_ms, t_100us, t_us, "
                           "t_ns, t_utc), week, " +
                           Listed(quantities) + ", skip");
      }
      if (!seen.insert(quantity).second) throw InvalidInput("'" + name + "' is named twice");
    }
  }
  if (!seen.contains("t")) throw InvalidInput("no column is the time, t");
}

TextTable ReadNamedColumns(const std::filesystem::path& file, const ColumnNames& names,
                           const std::vector<std::string>& quantities, std::size_t max_rows,
                           EmptyRows empty) {
  const ColumnLayout layout(names, quantities);
  TextTable table;
  table.file = file;
  table.columns = 1 + quantities.size();
  NamedRows rows(layout, empty, &table);
  LineReader lines(file);
  for (std::string_view line; table.rows() < max_rows && lines.Next(&line);) {
    rows.Take(line, lines.line());
  }
  if (table.rows() == 0) {
    throw InvalidInput("file has no rows of numbers with the " +
                           std::to_string(layout.least_fields()) + " columns that `columns` names",
                       {file.string(), 0, 0});
  }
  return table;
}

}  // namespace dn
