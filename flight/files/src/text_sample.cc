#include "text_sample.h"

#include <dn/error.h>
#include <dn/geo/gps_time.h>
#include <dn/geo/text_fields.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "calendar_text.h"
#include "column_meaning.h"
#include "gnss_meaning.h"

namespace dn::files_internal {
namespace {

using Fields = std::vector<std::string_view>;

constexpr std::size_t kLeastColumns = 4;
// A file with more lines before its first row is not a table.
constexpr std::size_t kMostHeaderLines = 10000;

/// Returns the value of a number or of a calendar time.
std::optional<double> FieldValue(std::string_view field) {
  const std::optional<double> number = FieldNumber(field);
  return number ? number : CalendarSeconds(field);
}

bool BeginsWithNumber(const Fields& fields) {
  return fields.size() > 1 && (FieldValue(fields[0]) || FieldValue(fields[1]));
}

/// Returns whether a date and the time of day are the first two fields.
bool BeginsWithDate(const Fields& fields) {
  const std::optional<DateColumn> date = FindDateColumn(fields);
  return date && date->at < 2 && date->time < 2;
}

bool IsRow(const Fields& fields) {
  if (fields.size() < kLeastColumns) return false;
  const auto numbers = std::count_if(fields.begin(), fields.end(), [](std::string_view field) {
    return FieldValue(field).has_value();
  });
  // Messages of a log may begin with a date, too.
  return (numbers > 1 && BeginsWithNumber(fields)) || (numbers > 2 && BeginsWithDate(fields));
}

std::vector<std::string> Names(const Fields& fields) { return {fields.begin(), fields.end()}; }

void AppendFields(const Fields& fields, long line, TextSample* sample) {
  TextTable& table = sample->table;
  for (std::size_t i = 0; i < table.columns; ++i) {
    auto value = i < fields.size() ? FieldValue(fields[i]) : std::nullopt;
    if (sample->date && i == sample->date->time) value = sample->date->Seconds(fields);
    table.values.push_back(value.value_or(std::numeric_limits<double>::quiet_NaN()));
  }
  table.lines.push_back(line);
}

/// Corrects the times if the names say that they are in GPS time.
void TakeGpsTime(TextSample* sample) {
  if (!sample->date || !NamesGpsTime(*sample->date, sample->names)) return;
  sample->date->is_gps = true;
  TextTable& table = sample->table;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    double& t_s = table.values[i * table.columns + sample->date->time];
    if (std::isfinite(t_s)) t_s -= GpsMinusUtcS({0, t_s});
  }
}

/// Returns the number of columns. The last field of the first row may be empty.
std::size_t CountColumns(std::string_view line, const Fields& fields,
                         const std::vector<std::vector<std::string>>& headers) {
  const std::size_t last = line.find_last_not_of(" \r");
  const bool ends_empty = last != line.npos && (line[last] == ',' || line[last] == ';');
  const std::size_t more = fields.size() + 1;
  const bool named = std::ranges::any_of(
      headers, [&](const std::vector<std::string>& names) { return names.size() == more; });
  return ends_empty && named ? more : fields.size();
}

/// Replaces the time of day by GPS seconds if dates and times are numbers.
void TakePlainDate(TextSample* sample) {
  if (sample->date) return;
  sample->date = FindPlainDate(sample->names, sample->table);
  if (!sample->date) return;
  TextTable& table = sample->table;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    double* row = table.values.data() + i * table.columns;
    row[sample->date->time] = *PlainSeconds(*sample->date, row);
  }
}

/// Returns whether the last fields of a line with tabs are empty.
bool EndsWithTab(std::string_view line) {
  const std::size_t last = line.find_last_not_of('\r');
  return last != std::string_view::npos && line[last] == '\t';
}

/// Splits a line where at least two blanks or a tab separate names of several words.
Fields SplitWide(std::string_view line) {
  Fields fields;
  while (true) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == line.npos) return fields;
    line.remove_prefix(begin);
    const std::size_t end =
        std::min({line.find("  "), line.find('\t'), line.find('\r'), line.size()});
    fields.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

/// Adds minutes and seconds to latitude and longitude if the rows have four more columns than the
/// line has names.
std::vector<std::string> WithMinutes(const std::vector<std::string>& names, std::size_t columns) {
  if (names.size() + 4 != columns) return names;
  std::vector<std::string> longer;
  for (const std::string& name : names) {
    longer.push_back(name);
    const std::string meaning = FindMeaning(name).name;
    if (meaning != "lat" && meaning != "lon") continue;
    longer.push_back(meaning + " min");
    longer.push_back(meaning + " sec");
  }
  return longer;
}

bool IsKnownName(const std::string& name) {
  return !FindMeaning(name).name.empty() || !FindMeaning(SpelledName(name)).name.empty();
}

/// Takes the names of the line with the most names of known meaning, such as those above a line of
/// units. Lines with as many names as columns are preferred.
void SetNames(const std::vector<std::vector<std::string>>& headers, TextSample* sample) {
  const std::size_t columns = sample->table.columns;
  std::ptrdiff_t most = 0;
  bool is_exact = false;
  for (const std::vector<std::string>& header : headers) {
    const std::vector<std::string> names = WithMinutes(header, columns);
    if (names.size() < columns || (is_exact && names.size() != columns)) continue;
    const auto known = std::count_if(names.begin(), names.end(), IsKnownName);
    const bool first_exact = names.size() == columns && !is_exact && known > 1;
    if (known <= most && !first_exact) continue;
    most = known;
    is_exact = names.size() == columns;
    sample->names.assign(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(columns));
  }
}

std::optional<std::size_t> FindName(const TextSample& sample, const std::string& meaning) {
  for (std::size_t i = 0; i < sample.names.size(); ++i) {
    if (FindMeaning(sample.names[i]).name == meaning) return i;
  }
  return std::nullopt;
}

/// Adds minutes and seconds to the degrees of an angle.
void AddMinutes(const std::string& angle, TextSample* sample) {
  const auto degrees = FindName(*sample, angle), minutes = FindName(*sample, angle + "_min"),
             seconds = FindName(*sample, angle + "_sec");
  if (!degrees || !minutes || !seconds) return;
  TextTable& table = sample->table;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    double* row = table.values.data() + i * table.columns;
    const double part = row[*minutes] / 60.0 + row[*seconds] / 3600.0;
    row[*degrees] += std::copysign(part, row[*degrees]);
  }
}

/// Returns whether a field is a number with a decimal comma.
bool HasDecimalComma(std::string_view field) {
  const std::size_t comma = field.find(',');
  return comma != field.npos && FieldNumber(field.substr(0, comma)) &&
         FieldNumber(field.substr(comma + 1));
}

/// Says why a line with numbers is not a row; empty if it has none.
std::string RowProblem(const Fields& fields) {
  const auto commas = std::count_if(fields.begin(), fields.end(), HasDecimalComma);
  if (commas > 1) {
    return "semicolons separate the columns and commas are decimal: write decimal points";
  }
  const auto numbers = std::count_if(fields.begin(), fields.end(),
                                     [](std::string_view field) { return !!FieldNumber(field); });
  if (fields.size() < kLeastColumns || numbers < 2) return {};
  for (std::size_t i = 0; i < 2; ++i) {
    if (IsCalendarText(fields[i])) return CalendarAdvice(std::to_string(i + 1), fields[i]);
  }
  return {};
}

}  // namespace

TextSample ReadTextSample(const std::filesystem::path& file, std::size_t max_rows) {
  TextSample sample;
  TextTable& table = sample.table;
  table.file = file;
  std::vector<std::vector<std::string>> headers;
  std::size_t most_fields = 0;
  std::string problem;
  LineReader lines(file);
  for (std::string_view line; table.rows() < max_rows && lines.Next(&line);) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) continue;
    const bool comment = line[begin] == '#' || line[begin] == '%';
    const std::string_view text = comment ? line.substr(begin + 1) : line;
    const Fields fields = SplitFields(text);
    if (comment || !IsRow(fields)) {
      if (BeginsWithNumber(fields)) most_fields = std::max(most_fields, fields.size());
      if (problem.empty() && table.columns == 0) problem = RowProblem(fields);
      if (table.columns == 0) {
        if (headers.size() > 2 * kMostHeaderLines) break;
        headers.push_back(Names(fields));
        headers.push_back(Names(SplitWide(text)));
      }
      sample.needs_names = sample.needs_names || !comment || line[begin] == '%';
      continue;
    }
    if (table.columns == 0) {
      table.columns = CountColumns(text, fields, headers);
      sample.first_row = Names(fields);
      sample.date = FindDateColumn(fields);
      sample.needs_names = sample.needs_names || line.find(';') != std::string_view::npos;
    }
    if (fields.size() + 1 >= table.columns || EndsWithTab(line)) {
      AppendFields(fields, lines.line(), &sample);
    }
  }
  if (table.rows() == 0) {
    if (!problem.empty()) throw InvalidInput(problem);
    if (most_fields > 0 && most_fields < kLeastColumns) {
      throw InvalidInput(std::to_string(most_fields) +
                         " columns, which match no known kind of file");
    }
    throw InvalidInput("no line has numbers in its first two columns", {file.string()});
  }
  SetNames(headers, &sample);
  TakePlainDate(&sample);
  TakeGpsTime(&sample);
  for (const char* angle : {"lat", "lon"}) AddMinutes(angle, &sample);
  return sample;
}

}  // namespace dn::files_internal
