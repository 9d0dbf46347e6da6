#pragma once

#include <dn/diagnosis/diagnosis.h>
#include <dn/geo/local_frame.h>

#include <string>
#include <vector>

namespace dn::diagnosis_internal {

inline constexpr double kMmPerM = 1e3;
inline constexpr double kMdegPerRad = 1e3 * kDegPerRad;

/// Returns a value with the given number of significant digits: "0.0012", "930", "1.2e+06".
std::string Rounded(double value, int digits);

/// Returns "p = 0.02", or "p < 1e-12" for smaller values.
std::string PWords(double p_value);

/// Returns whether the diagnosis contains shifts of the boresight. It does not without pairs.
bool HasBoresight(const GapDiagnosis& diagnosis);

/// Returns the result that the flight is for: "boresight", or "trajectory" without pairs.
const char* ResultWord(const GapDiagnosis& diagnosis);

/// Returns values with their sigmas: "0.1 +- 0.004, 0 +- 0.004, -0.05 +- 0.006 m". Names the
/// components if their units differ: "sigma 0.3 +- 0.05 deg/h, tau 90 +- 30 s". A value that is
/// equal on all axes is written once. Returns "" if no size was measured.
std::string ValueWords(const GapCause& cause);

/// Returns " from 381400 to 381450 s", " from 381500 s on", or "".
std::string TimesWords(const EffectTimes& times);

/// Returns "GNSS oscillation, 46 s", "boresight that settles, tau 50 s", or the name alone.
std::string DiscrepancyWords(const GapDiscrepancy& discrepancy);

/// Returns "3.1, -0.2, 14 mdeg" for three angles in rad.
std::string MdegWords(const Eigen::Vector3d& rad);

/// Returns "a", "a or b", or "a, b or c".
std::string Alternatives(const std::vector<std::string>& names);

/// Returns "97 % of the gap (90 to 99)", or "nothing of the gap". A lower bound below 0 is written
/// as "below 0". A share below 1 is never rounded to 100 %.
std::string ClosedWords(const GapShrinkage& shrinkage);

/// Returns why an effect with much evidence is improbable. Examples: "-0.3 nats are left with the
/// named effects", "120 nats less than laser vectors by strip". Returns "" for all other effects.
std::string WeakerWords(const GapDiagnosis& diagnosis, const GapCause& cause);

/// Returns the minimal detectable bias: "0.0012 s", or one value per component, "1.2, 3.1, 0.05
/// deg/h/g (x, y, z alone)". A component that is undetectable at any size is written as "any".
std::string DetectableWords(const DetectionLimit& effect);

/// Sorts effects by the possible shift of the boresight, largest first; unbounded shifts come
/// before all others.
std::vector<DetectionLimit> MostHarmful(std::vector<DetectionLimit> effects);

}  // namespace dn::diagnosis_internal
