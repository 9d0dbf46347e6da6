#include <dn/geo/text_fields.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <system_error>

namespace dn {
namespace {

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kAround = " \t\r\"";
  const std::size_t begin = text.find_first_not_of(kAround);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kAround) + 1 - begin);
}

std::vector<std::string_view> SplitAtBlanks(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0; (begin = line.find_first_not_of(kBlanks, begin)) != line.npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    fields.push_back(Trimmed(line.substr(begin, end - begin)));
    begin = end;
  }
  return fields;
}

/// Splits a line at separators outside quotation marks.
std::vector<std::string_view> SplitAt(std::string_view line, std::string_view separators) {
  std::vector<std::string_view> fields;
  bool quoted = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (quoted || separators.find(line[i]) == std::string_view::npos) continue;
    fields.push_back(Trimmed(line.substr(begin, i - begin)));
    begin = i + 1;
  }
  const std::string_view last = Trimmed(line.substr(begin));
  if (!last.empty()) fields.push_back(last);
  return fields;
}

/// Returns the line without a checksum at its end, such as "*5F".
std::string_view WithoutChecksum(std::string_view line) {
  const std::size_t end = line.find_last_not_of(" \t\r");
  if (end == std::string_view::npos || end < 3 || line[end - 2] != '*') return line;
  const auto is_digit = [](char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0; };
  return is_digit(line[end - 1]) && is_digit(line[end]) ? line.substr(0, end - 2) : line;
}

}  // namespace

std::vector<std::string_view> SplitFields(std::string_view line) {
  line = WithoutChecksum(line);
  const bool semicolons = line.find(';') != std::string_view::npos;
  if (!semicolons && line.find(',') == std::string_view::npos) return SplitAtBlanks(line);
  return SplitAt(line, semicolons ? ";" : ",");
}

std::vector<std::string_view> SplitMessage(std::string_view line) {
  const std::size_t begin = line.find_first_not_of(" \t\r#%$");
  if (begin == std::string_view::npos) return {};
  line = line.substr(begin);
  line = line.substr(0, line.rfind('*'));
  if (line.find_first_of(",;") == std::string_view::npos) return SplitAtBlanks(line);
  return SplitAt(line, ",;");
}

std::optional<double> FieldNumber(std::string_view field) {
  if (field.starts_with('+')) field.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  const bool whole = error == std::errc() && end == field.data() + field.size();
  return whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace dn
