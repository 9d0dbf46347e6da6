#pragma once

#include <dn/error.h>

#include <string>

namespace dn {

/// One week, s.
inline constexpr double kWeekS = 604800.0;

/// Returns true if t_s may be GPS seconds of week, including flights that cross the end of one or
/// two weeks.
inline bool IsWeekSeconds(double t_s) { return t_s >= -3600.0 && t_s <= 1.3e6; }

/// Throws InvalidInput at `where` unless IsWeekSeconds. The message says what the value may be
/// (milliseconds, time since 1980 or 1970, ...) and how to convert it.
void CheckWeekSeconds(double t_s, const FileLocation& where);

/// Returns a hint if t_s / 1e3, / 1e6 or / 1e9 lies within [begin_s, end_s] and t_s does not;
/// otherwise an empty string. The hint names the matching unit: "; is the time in milliseconds?
/// Divide it by 1000".
std::string TimeUnitHint(double t_s, double begin_s, double end_s);

}  // namespace dn
