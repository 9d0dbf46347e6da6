#include <dn/error.h>
#include <dn/geo/gps_time.h>
#include <dn/geo/text_fields.h>
#include <dn/geo/week_seconds.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

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

/// Adds the zeros at the beginning of a number that a table of numbers loses.
std::string WithLeadingZeros(std::string_view number, std::size_t digits) {
  const std::size_t whole = std::min(number.find('.'), number.size());
  return whole == 0 || whole >= digits ? std::string(number)
                                       : std::string(digits - whole, '0') + std::string(number);
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

/// Year, month and day.
using Date = std::array<int, 3>;

/// Returns the number of a text of one or two digits, or of four.
std::optional<int> DatePart(std::string_view text) {
  return text.empty() || text.size() == 3 || text.size() > 4 ? std::nullopt
                                                             : Digits(text, 0, text.size());
}

/// Splits a date at its separators, or after two digits for each of the last or first numbers.
std::optional<std::array<std::string_view, 3>> DateParts(std::string_view text, DateOrder order) {
  const std::size_t first = text.find_first_not_of("0123456789");
  if (first == text.npos) {
    if (text.size() != 6 && text.size() != 8) return std::nullopt;
    const std::size_t year = text.size() - 4, a = order == DateOrder::kYearFirst ? year : 2;
    return std::array{text.substr(0, a), text.substr(a, 2), text.substr(a + 2)};
  }
  const std::size_t second = text.find(text[first], first + 1);
  if (std::string_view("-/.").find(text[first]) == std::string_view::npos || second == text.npos) {
    return std::nullopt;
  }
  return std::array{text.substr(0, first), text.substr(first + 1, second - first - 1),
                    text.substr(second + 1)};
}

std::optional<Date> FindDate(std::string_view text, DateOrder order) {
  const auto parts = DateParts(text, order);
  if (!parts) return std::nullopt;
  const auto a = DatePart((*parts)[0]), b = DatePart((*parts)[1]), c = DatePart((*parts)[2]);
  if (!a || !b || !c || (*parts)[1].size() > 2) return std::nullopt;
  const bool dots = text.find('.') != text.npos && (*parts)[2].size() == 4;
  if (dots) order = DateOrder::kDayFirst;
  Date date{*c, *b, *a};
  if (order == DateOrder::kMonthFirst) date = {*c, *a, *b};
  if (order == DateOrder::kYearFirst) date = {*a, *b, *c};
  const bool has_separators = text.find_first_not_of("0123456789") != text.npos;
  const std::size_t year_digits = (*parts)[order == DateOrder::kYearFirst ? 0 : 2].size();
  if (order == DateOrder::kYearFirst && has_separators && year_digits != 4) return std::nullopt;
  if (year_digits < 4) date[0] += 2000;
  return date;
}

}  // namespace

std::optional<double> DateSeconds(std::string_view text, DateOrder order) {
  const bool separators = text.find_first_not_of("0123456789") != text.npos;
  const std::string padded =
      separators ? std::string(text) : WithLeadingZeros(text, text.size() > 6 ? 8 : 6);
  const std::optional<Date> date = FindDate(padded, order);
  if (!date) return std::nullopt;
  try {
    const GpsTime utc = CalendarToGpsTime((*date)[0], (*date)[1], (*date)[2], 0, 0, 0.0);
    return kWeekS * static_cast<double>(utc.week) + utc.tow_s + GpsMinusUtcS(utc);
  } catch (const InvalidInput&) {  // there is no such date
    return std::nullopt;
  }
}

std::optional<double> SecondsIntoDay(std::string_view text) {
  const bool colons = text.find(':') != text.npos;
  const bool short_hours = text.size() > 1 && text[1] == ':';
  const std::string padded =
      colons ? (short_hours ? "0" : "") + std::string(text) : WithLeadingZeros(text, 6);
  const std::size_t step = colons ? 3 : 2;
  const auto hours = Digits(padded, 0, 2), minutes = Digits(padded, step, 2);
  if (!hours || !minutes || !Digits(padded, 2 * step, 2)) return std::nullopt;
  if (colons && (padded[2] != ':' || padded[5] != ':')) return std::nullopt;
  const std::string_view rest = std::string_view(padded).substr(2 * step);
  const bool is_number = rest.find_first_not_of("0123456789.") == rest.npos;
  const auto seconds =
      is_number && (rest.size() == 2 || rest[2] == '.') ? FieldNumber(rest) : std::nullopt;
  if (!seconds || *hours > 23 || *minutes > 59 || *seconds >= 61.0) return std::nullopt;
  return 60.0 * (60.0 * *hours + *minutes) + *seconds;
}

std::optional<double> CalendarSeconds(std::string_view text) {
  const std::size_t between = text.find_first_of("T ");
  if (between == text.npos) return std::nullopt;
  const std::string_view time = text.substr(between + 1);
  const std::size_t end = std::min(time.find_first_not_of("0123456789.:"), time.size());
  const auto day_s = DateSeconds(text.substr(0, between), DateOrder::kYearFirst);
  const bool colons = time.find(':') < 3;
  const auto time_s = colons ? SecondsIntoDay(time.substr(0, end)) : std::nullopt;
  const auto zone_s = ZoneSeconds(time.substr(end));
  if (!day_s || !time_s || !zone_s) return std::nullopt;
  return *day_s + *time_s - *zone_s;
}

}  // namespace dn
