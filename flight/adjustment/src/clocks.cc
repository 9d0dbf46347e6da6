#include <dn/adjustment/clocks.h>

#include <cmath>

namespace dn {

ClockEstimate ClockEstimate::WithoutDrift() const {
  if (!(sigma_drift > 0.0)) return {offset_s, sigma_offset_s};
  return {offset_s - correlation * sigma_offset_s / sigma_drift * drift,
          sigma_offset_s * std::sqrt(1.0 - correlation * correlation)};
}

ClockEstimate ClockEstimate::WithoutOffset() const {
  if (!(sigma_offset_s > 0.0)) return {0.0, 0.0, drift, sigma_drift};
  return {0.0, 0.0, drift - correlation * sigma_drift / sigma_offset_s * offset_s,
          sigma_drift * std::sqrt(1.0 - correlation * correlation)};
}

}  // namespace dn
