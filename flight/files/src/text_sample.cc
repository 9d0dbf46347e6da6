#include "text_sample.h"

#include <dn/error.h>
#include <dn/geo/text_fields.h>

#include <algorithm>
#include <limits>

#include "column_meaning.h"

namespace dn::files_internal {
namespace {

using Fields = std::vector<std::string_view>;

constexpr std::size_t kLeastColumns = 4;

bool IsRow(const Fields& fields) {
  if (fields.size() < 2) return false;
  return FieldNumber(fields[0]).has_value() || FieldNumber(fields[1]).has_value();
}

std::vector<std::string> Names(const Fields& fields) { return {fields.begin(), fields.end()}; }

void AppendFields(const Fields& fields, long line, TextTable* table) {
  for (std::size_t i = 0; i < table->columns; ++i) {
    table->values.push_back(
        FieldNumber(fields[i]).value_or(std::numeric_limits<double>::quiet_NaN()));
  }
  table->lines.push_back(line);
}

/// Takes the names of the line with the most names of known meaning, such as those above a line of
/// units.
void SetNames(const std::vector<std::vector<std::string>>& headers, TextSample* sample) {
  std::ptrdiff_t most = 0;
  for (const std::vector<std::string>& names : headers) {
    if (names.size() < sample->table.columns) continue;
    const auto known = std::count_if(names.begin(), names.end(), [](const std::string& name) {
      return !FindMeaning(name).name.empty();
    });
    if (known <= most) continue;
    most = known;
    sample->names.assign(names.begin(),
                         names.begin() + static_cast<std::ptrdiff_t>(sample->table.columns));
  }
}

}  // namespace

TextSample ReadTextSample(const std::filesystem::path& file, std::size_t max_rows) {
  TextSample sample;
  TextTable& table = sample.table;
  table.file = file;
  std::vector<std::vector<std::string>> headers;
  LineReader lines(file);
  for (std::string_view line; table.rows() < max_rows && lines.Next(&line);) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) continue;
    const bool comment = line[begin] == '#' || line[begin] == '%';
    const Fields fields = SplitFields(comment ? line.substr(begin + 1) : line);
    if (comment || !IsRow(fields)) {
      if (table.columns == 0) headers.push_back(Names(fields));
      sample.needs_names = sample.needs_names || !comment || line[begin] == '%';
      continue;
    }
    if (table.columns == 0) {
      if (fields.size() < kLeastColumns) {
        throw InvalidInput(std::to_string(fields.size()) +
                           " columns, which match no known kind of file");
      }
      table.columns = fields.size();
      sample.needs_names = sample.needs_names || line.find(';') != std::string_view::npos;
    }
    if (fields.size() >= table.columns) AppendFields(fields, lines.line(), &table);
  }
  if (table.rows() == 0) {
    throw InvalidInput("no line has numbers in its first two columns", {file.string()});
  }
  SetNames(headers, &sample);
  return sample;
}

}  // namespace dn::files_internal
