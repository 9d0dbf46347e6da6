#pragma once

namespace dn::internal {

/// Nothing that surveys moves faster, m/s.
constexpr double kMostSpeedMps = 1000.0;
/// Of a degree of latitude.
constexpr double kMetresPerDeg = 111000.0;

}  // namespace dn::internal
