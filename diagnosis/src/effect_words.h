#pragma once

#include <dn/gap/diagnosis.h>
#include <dn/geo/local_frame.h>

#include <string>
#include <vector>

namespace dn::internal {

inline constexpr double kMmPerM = 1e3;
inline constexpr double kMdegPerRad = 1e3 * kDegPerRad;

/// To so many significant digits: "0.0012", "930", "1.2e+06".
std::string Rounded(double value, int digits);

/// "p = 0.02", "p < 1e-12".
std::string PWords(double p_value);

/// Whether the diagnosis tells how effects move a boresight: not without pairs.
bool HasBoresight(const GapDiagnosis& diagnosis);

/// "0.1 +- 0.004, 0 +- 0.004, -0.05 +- 0.006 m", or each component by its name where units differ:
/// "sigma 0.3 +- 0.05 deg/h, tau 90 +- 30 s". What is the same on every axis is said once.
std::string ValueWords(const GapCause& cause);

/// " from 381400 to 381450 s", " from 381500 s on", or nothing.
std::string TimesWords(const EffectTimes& times);

/// "GNSS oscillation, 46 s", "boresight that settles, tau 50 s", or the name alone.
std::string DiscrepancyWords(const GapDiscrepancy& discrepancy);

/// "3.1, -0.2, 14 mdeg".
std::string MdegWords(const Eigen::Vector3d& rad);

/// "a", "a or b", "a, b or c".
std::string Alternatives(const std::vector<std::string>& names);

/// "97 % of the gap (90 to 99)"; a lower end below 0 is called so.
std::string ClosedWords(const GapShrinkage& shrinkage);

/// "0.0012 s", or where an effect has several components, of each alone: "1.2, 3.1, 0.05 deg/h/g (x, y,
/// z alone)"; what no size shows is "any".
std::string DetectableWords(const HiddenEffect& effect);

/// By how much they could move the boresight, most first; what has no bound before all others.
std::vector<HiddenEffect> MostHarmful(std::vector<HiddenEffect> effects);

}  // namespace dn::internal
