#include "detectability.h"

#include <dn/solvers/fit_check.h>

#include <cmath>
#include <limits>

namespace dn::internal {

double MinimalDetectableBias(double information, double signature2) {
  if (!(information > kAbsorbedShare * signature2)) return std::numeric_limits<double>::infinity();
  return OutlierTest().NonCentrality() / std::sqrt(information);
}

}  // namespace dn::internal
