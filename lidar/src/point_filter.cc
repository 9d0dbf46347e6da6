#include <dn/lidar/point_filter.h>

namespace dn {
namespace {

bool IsNoise(std::uint8_t point_class) {
  constexpr std::uint8_t kLowNoise = 7, kHighNoise = 18;
  return point_class == kLowNoise || point_class == kHighNoise;
}

}  // namespace

const char* DropReason(const PointFilter& filter, const StripCloud& points, std::size_t i) {
  const std::uint8_t flags = points.flags.empty() ? 0 : points.flags[i];
  if ((flags & StripCloud::kWithheld) != 0) return "withheld";
  if ((flags & StripCloud::kSynthetic) != 0) return "synthetic";
  if (filter.last_returns && !points.returns_after.empty() && points.returns_after[i] > 0) {
    return "not the last return of its pulse";
  }
  const bool has_class = !points.classification.empty();
  if (filter.classes.empty()) {
    return has_class && IsNoise(points.classification[i]) ? "classified as noise" : nullptr;
  }
  return has_class && filter.classes.contains(points.classification[i]) ? nullptr
                                                                        : "of another class";
}

}  // namespace dn
