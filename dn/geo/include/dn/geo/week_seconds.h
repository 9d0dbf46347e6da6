#pragma once

#include <dn/error.h>

#include <string>

namespace dn {

/// One week, s.
inline constexpr double kWeekS = 604800.0;

/// Whether t_s may be GPS seconds of week, also of a flight that crosses the end of a week or two.
inline bool IsSecondsOfWeek(double t_s) { return t_s >= -3600.0 && t_s <= 1.3e6; }

/// Throws InvalidInput at `where` unless IsSecondsOfWeek. The message says what the value looks
/// like (milliseconds, time since 1980 or 1970, ..) and how it is converted.
void CheckSecondsOfWeek(double t_s, const FileLocation& where);

/// "; is the time in milliseconds? Divide it by 1000" when a thousandth, millionth or billionth of
/// t_s lies within [begin_s, end_s] and t_s does not; empty otherwise.
std::string TimeUnitHint(double t_s, double begin_s, double end_s);

}  // namespace dn
