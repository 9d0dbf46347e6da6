#include <dn/error.h>
#include <dn/geo/gps_time.h>
#include <dn/geo/text_fields.h>
#include <dn/geo/week_seconds.h>

#include <algorithm>
#include <cctype>

namespace dn {
namespace {

/// Returns the value of `count` digits at a place; nullopt if they are not digits.
std::optional<int> Digits(std::string_view text, std::size_t at, std::size_t count) {
  if (text.size() < at + count) return std::nullopt;
  const std::string_view part = text.substr(at, count);
  const bool digits = std::all_of(part.begin(), part.end(), [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
  });
  return digits ? std::optional(static_cast<int>(*FieldNumber(part))) : std::nullopt;
}

/// Returns the seconds of an offset such as "Z", "+02:00" or "-0330"; no text means UTC.
std::optional<double> ZoneSeconds(std::string_view text) {
  if (text.empty() || text == "Z" || text == "z") return 0.0;
  if (text[0] != '+' && text[0] != '-') return std::nullopt;
  const auto hours = Digits(text, 1, 2);
  const std::size_t at = text.size() > 3 && text[3] == ':' ? 4 : 3;
  const auto minutes = text.size() > 3 ? Digits(text, at, 2) : std::optional(0);
  if (!hours || !minutes || text.size() > at + 2) return std::nullopt;
  return (text[0] == '-' ? -60.0 : 60.0) * (60.0 * *hours + *minutes);
}

}  // namespace

std::optional<double> CalendarSeconds(std::string_view text) {
  const auto year = Digits(text, 0, 4), month = Digits(text, 5, 2), day = Digits(text, 8, 2),
             hour = Digits(text, 11, 2), minute = Digits(text, 14, 2);
  if (!year || !month || !day || !hour || !minute || text.size() < 19) return std::nullopt;
  const bool date = (text[4] == '-' || text[4] == '/') && text[7] == text[4];
  if (!date || (text[10] != 'T' && text[10] != ' ') || text[13] != ':' || text[16] != ':') {
    return std::nullopt;
  }
  const std::size_t end = std::min(text.find_first_not_of("0123456789.", 17), text.size());
  const auto second = FieldNumber(text.substr(17, end - 17));
  const auto zone_s = ZoneSeconds(text.substr(end));
  if (!second || !zone_s) return std::nullopt;
  try {
    const GpsTime utc = CalendarToGpsTime(*year, *month, *day, *hour, *minute, *second);
    return kWeekS * static_cast<double>(utc.week) + utc.tow_s - *zone_s + GpsMinusUtcS(utc);
  } catch (const InvalidInput&) {  // there is no such date
    return std::nullopt;
  }
}

}  // namespace dn
