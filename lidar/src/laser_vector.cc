#include "laser_vector.h"

#include <dn/geo/text_table.h>

namespace dn::internal {
namespace {

constexpr double kShortestRangeM = 1e-3;
constexpr double kLongestRangeM = 50e3;

}  // namespace

void CheckLaserVector(const Eigen::Vector3d& u_m, const FileLocation& where) {
  if (!u_m.allFinite()) throw InvalidInput("laser vector that is no finite number", where);
  const double range_m = u_m.stableNorm();
  if (range_m >= kShortestRangeM && range_m <= kLongestRangeM) return;
  if (range_m == 0.0) throw InvalidInput("laser vector of zero length; remove it", where);
  throw InvalidInput("laser vector of length " + FormatDouble(range_m) +
                         " in the unit that should be metres, must lie within 0.001 and 50000: " +
                         (range_m > kLongestRangeM ? "is it in millimetres? Divide it by 1000"
                                                   : "is it in kilometres? Multiply it by 1000"),
                     where);
}

}  // namespace dn::internal
