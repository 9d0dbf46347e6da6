#include "laser_vector.h"

#include <dn/geo/text_table.h>

namespace dn::lidar_internal {
namespace {

constexpr double kShortestRangeM = 1e-3;
constexpr double kLongestRangeM = 50e3;

}  // namespace

void CheckLaserVector(const Eigen::Vector3d& u_m, const FileLocation& where) {
  if (!u_m.allFinite()) throw InvalidInput("laser vector is not finite", where);
  const double range_m = u_m.stableNorm();
  if (range_m >= kShortestRangeM && range_m <= kLongestRangeM) return;
  if (range_m == 0.0) throw InvalidInput("laser vector has zero length; remove it", where);
  throw InvalidInput("laser vector has length " + FormatDouble(range_m) +
                         ", must lie between 0.001 and 50000 m: " +
                         (range_m > kLongestRangeM ? "is it in millimetres? Divide it by 1000"
                                                   : "is it in kilometres? Multiply it by 1000"),
                     where);
}

}  // namespace dn::lidar_internal
