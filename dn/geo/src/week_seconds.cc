#include <dn/geo/text_table.h>
#include <dn/geo/week_seconds.h>

#include <array>
#include <cmath>

namespace dn {
namespace {

/// Hint for values below `limit`.
struct Look {
  double limit;
  const char* hint;
};

constexpr std::array<Look, 8> kLooks{
    {{8e8,
      "is it in milliseconds? Divide it by 1000. Is it the adjusted GPS time of LAS files? Add "
      "1e9, "
      "then subtract 604800 times the GPS week"},
     {3e9,
      "is it GPS time since 1980? Subtract 604800 times the GPS week. Is it Unix time? Subtract "
      "315964800, add the leap seconds (18 since 2017), then subtract 604800 times the GPS week"},
     {7e11, "is it in microseconds? Divide it by 1e6"},
     {3e12,
      "is it in milliseconds since 1980 or 1970? Divide it by 1000, then take the seconds of the "
      "GPS week"},
     {7e14, "is it in nanoseconds? Divide it by 1e9"},
     {3e15,
      "is it in microseconds since 1980 or 1970? Divide it by 1e6, then take the seconds of the "
      "GPS week"},
     {3e18,
      "is it in nanoseconds since 1980 or 1970? Divide it by 1e9, then take the seconds of the GPS "
      "week"},
     {INFINITY, "is this column the time?"}}};

struct Unit {
  double per_second;
  const char* name;
  const char* divisor;
};

constexpr std::array<Unit, 3> kUnits{
    {{1e3, "milliseconds", "1000"}, {1e6, "microseconds", "1e6"}, {1e9, "nanoseconds", "1e9"}}};

const char* TimeAppearance(double t_s) {
  if (t_s < 0.0) return "is this column the time?";
  for (const Look& look : kLooks) {
    if (t_s < look.limit) return look.hint;
  }
  return kLooks.back().hint;
}

}  // namespace

void CheckWeekSeconds(double t_s, const FileLocation& where) {
  if (IsWeekSeconds(t_s)) return;
  throw InvalidInput("time " + FormatDouble(t_s) +
                         " cannot be GPS seconds of week, which lie between 0 and 604800 s (more "
                         "after the end of a week): " +
                         TimeAppearance(t_s),
                     where);
}

std::string TimeUnitHint(double t_s, double begin_s, double end_s) {
  const auto inside = [&](double t) { return t >= begin_s && t <= end_s; };
  if (inside(t_s)) return {};
  for (const Unit& unit : kUnits) {
    if (inside(t_s / unit.per_second)) {
      return std::string("; is the time in ") + unit.name + "? Divide it by " + unit.divisor;
    }
  }
  return {};
}

}  // namespace dn
