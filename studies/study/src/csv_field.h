#pragma once

#include <string>

namespace dn {

/// Returns a field of a CSV file, in quotes if it needs them (RFC 4180).
inline std::string CsvField(const std::string& field) {
  if (field.find_first_of(",\"\n\r") == std::string::npos) return field;
  std::string quoted = "\"";
  for (const char c : field) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace dn
