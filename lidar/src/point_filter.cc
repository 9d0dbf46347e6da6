#include <dn/lidar/point_filter.h>

namespace dn {

const char* DropReason(const PointFilter& filter, const StripCloud& points, std::size_t i) {
  if (filter.last_returns && !points.returns_after.empty() && points.returns_after[i] > 0) {
    return "not the last return of its pulse";
  }
  if (filter.classes.empty()) return nullptr;
  if (points.classification.empty() || !filter.classes.contains(points.classification[i])) {
    return "of another class";
  }
  return nullptr;
}

}  // namespace dn
