#include "checks.h"

#include <dn/error.h>

#include <cmath>
#include <sstream>
#include <string>

namespace dn::matching_internal {

void CheckPositive(const char* name, double length_m) {
  if (length_m > 0.0 && std::isfinite(length_m)) return;
  throw InvalidInput(std::string(name) + " is " + std::to_string(length_m) +
                     " m, must be positive and finite");
}

void CheckPoints(const std::vector<Eigen::Vector3d>& points_m, double bound_m) {
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const Eigen::Vector3d& p = points_m[i];
    if (p.allFinite() && p.cwiseAbs().maxCoeff() <= bound_m) continue;
    std::ostringstream what;
    what << "point " << i << " of " << points_m.size() << " is (" << p.transpose()
         << ") m: coordinates must be finite and at most " << bound_m << " m in magnitude";
    throw InvalidInput(what.str());
  }
}

}  // namespace dn::matching_internal
