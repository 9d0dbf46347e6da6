#include "error_process.h"

#include <cmath>

namespace dn::fixed_trajectory_internal {

double ErrorProcess::Correlation(double apart_s, bool same_strip) const {
  switch (kind) {
    case Kind::kGaussMarkov:
      return std::exp(-apart_s / tau_s);
    case Kind::kPerStrip:
      break;
  }
  return same_strip ? 1.0 : 0.0;
}

}  // namespace dn::fixed_trajectory_internal
