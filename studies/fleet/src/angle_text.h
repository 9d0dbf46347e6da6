#pragma once

#include <dn/fleet/fleet.h>
#include <dn/report/value_words.h>

#include <string>

namespace dn::fleet_internal {

/// Returns three angles in deg with their sigmas, as "0.0012 +- 0.0003, ...".
inline std::string AnglesWithSigma(const UncertainAngles& angles) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text += (i == 0 ? "" : ", ") +
            FormatWithSigma(angles.rad[i] * kDegPerRad, angles.sigma_rad()[i] * kDegPerRad);
  }
  return text;
}

}  // namespace dn::fleet_internal
