#include "nmea_sentence.h"

#include <dn/geo/text_table.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string>
#include <system_error>

namespace dn::gnss_internal {

std::vector<std::string_view> SplitSentence(std::string_view line) {
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
  const std::size_t dollar = line.find('$');
  if (dollar == std::string_view::npos) return {};
  line.remove_prefix(dollar + 1);
  const std::size_t star = line.find('*');
  if (dollar > 0 && star == std::string_view::npos) return {};
  if (star != std::string_view::npos) {
    unsigned sum = 0, stated = 256;
    for (const char c : line.substr(0, star)) sum ^= static_cast<unsigned char>(c);
    std::from_chars(line.data() + star + 1, line.data() + line.size(), stated, 16);
    if (sum != stated) return {};
    line = line.substr(0, star);
  }
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return fields;
}

bool IsSentence(const std::vector<std::string_view>& fields, std::string_view type,
                std::size_t least) {
  return fields.size() >= least && fields[0].size() == 5 && fields[0].substr(2) == type;
}

int TwoDigits(std::string_view field, std::size_t at) {
  int value = -1;
  if (field.size() < at + 2) return -1;
  const char* end = field.data() + at + 2;
  const auto [parsed, error] = std::from_chars(field.data() + at, end, value);
  return error == std::errc() && parsed == end ? value : -1;
}

double DaySeconds(std::string_view field, const FileLocation& where) {
  const int hour = TwoDigits(field, 0), minute = TwoDigits(field, 2);
  if (hour < 0 || hour > 23 || minute < 0 || minute > 59 || field.size() < 6) {
    throw InvalidInput("the time of an NMEA sentence is not hhmmss", where);
  }
  const double second = ParseNumber(field.substr(4), where);
  if (!(second >= 0.0 && second < 61.0)) {
    throw InvalidInput("the time of an NMEA sentence is not hhmmss", where);
  }
  return 3600.0 * hour + 60.0 * minute + second;
}

double Degrees(std::string_view field, std::string_view hemisphere, char positive, char negative,
               const FileLocation& where) {
  const double value = ParseNumber(field, where);
  const double degrees = std::floor(value / 100.0);
  const double angle = degrees + (value - 100.0 * degrees) / 60.0;
  const int letter =
      hemisphere.size() == 1 ? std::toupper(static_cast<unsigned char>(hemisphere[0])) : 0;
  if (value < 0.0 || (letter != positive && letter != negative)) {
    throw InvalidInput(std::string("the position of a GGA sentence has no hemisphere ") + positive +
                           " or " + negative + " after '" + std::string(field) +
                           "'; without it the sign is unknown",
                       where);
  }
  return letter == negative ? -angle : angle;
}

}  // namespace dn::gnss_internal
