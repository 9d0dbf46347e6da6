#pragma once

#include <dn/error.h>

#include <cstddef>
#include <string_view>
#include <vector>

namespace dn::gnss_internal {

/// Returns the fields of "$GPGGA,...*hh" without '$' and checksum. The result is empty for a line
/// that is not a sentence or has a wrong checksum. A logger may have written text before a sentence
/// with a checksum.
std::vector<std::string_view> SplitSentence(std::string_view line);

/// Returns whether the fields are those of a sentence of this type, such as "GGA", from any talker.
bool IsSentence(const std::vector<std::string_view>& fields, std::string_view type,
                std::size_t least);

/// Parses two digits of a field from position `at` on; returns -1 if they are not digits.
int TwoDigits(std::string_view field, std::size_t at);

/// Parses "hhmmss.ss" and returns the seconds of the day.
double DaySeconds(std::string_view field, const FileLocation& where);

/// Converts "dddmm.mmmm" to degrees. `positive` and `negative` are the letters of the hemispheres.
double Degrees(std::string_view field, std::string_view hemisphere, char positive, char negative,
               const FileLocation& where);

}  // namespace dn::gnss_internal
