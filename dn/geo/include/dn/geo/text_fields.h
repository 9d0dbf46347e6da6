#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace dn {

/// Splits a line into its fields, without blanks and quotation marks around them. Fields are
/// separated by semicolons if the line has any, else by commas if it has any, else by blanks and
/// tabs. A separator inside quotation marks belongs to its field. A semicolon or comma at the end
/// of the line does not begin another field, and a checksum there such as "*5F" is left out.
std::vector<std::string_view> SplitFields(std::string_view line);

/// Splits a line of a log whose lines begin with the name of their message, as in
/// "%RAWIMUSA,2280,381000.0;2280,381000.005,...*c01b540c". The sign before the name (#, % or $)
/// and the checksum belong to no field. Commas and semicolons both separate; without them, blanks.
std::vector<std::string_view> SplitMessage(std::string_view line);

/// Returns the value of a field that is a finite number.
std::optional<double> FieldNumber(std::string_view field);

}  // namespace dn
