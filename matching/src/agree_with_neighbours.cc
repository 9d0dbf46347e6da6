#include "agree_with_neighbours.h"

#include <dn/median.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "median_by_axis.h"
#include "shift_trend.h"

namespace dn::matching_internal {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kNeighbours = 8;
constexpr std::size_t kFewest = 4;
constexpr double kMostSigmas = 3.5;
// Variance of the difference between a value and the median of eight others of the same accuracy.
constexpr double kWithMedian = 1.2;

/// Returns the shifts minus a plane over east and north. Such a plane is the effect of a constant
/// attitude error between two strips.
std::vector<PlacedShift> WithoutTrend(std::vector<PlacedShift> shifts) {
  const ShiftTrend trend = FitTrend(shifts);
  for (PlacedShift& shift : shifts) shift.shift_m -= trend.At(shift.at_en_m);
  return shifts;
}

/// Returns the median of the shifts of the nearest neighbours, per axis.
Vector3d NeighbourMedian(std::size_t i, const std::vector<PlacedShift>& shifts) {
  std::vector<std::size_t> others(shifts.size());
  std::iota(others.begin(), others.end(), std::size_t{0});
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
  const std::size_t count = std::min(kNeighbours, others.size());
  const auto off_m2 = [&](std::size_t k) {
    return (shifts[k].at_en_m - shifts[i].at_en_m).squaredNorm();
  };
  std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count),
                    others.end(),
                    [&](std::size_t p, std::size_t q) { return off_m2(p) < off_m2(q); });
  std::vector<Vector3d> nearest;
  for (std::size_t k = 0; k < count; ++k) nearest.push_back(shifts[others[k]].shift_m);
  return MedianByAxis(nearest);
}

}  // namespace

Agreement AgreeWithNeighbours(const std::vector<PlacedShift>& given) {
  Agreement out;
  out.agrees.assign(given.size(), true);
  if (given.size() < kFewest) return out;
  const std::vector<PlacedShift> shifts = WithoutTrend(given);
  std::vector<Vector3d> left(shifts.size());
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    left[i] = (shifts[i].shift_m - NeighbourMedian(i, shifts)).array() /
              shifts[i].covariance_m2.diagonal().array().sqrt();
  }
  double variance = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> sizes;
    for (const Vector3d& value : left) sizes.push_back(std::abs(value[axis]));
    const double scale = std::max(1.0, kSigmaPerMedian * Median(sizes));
    variance += scale * scale / 3.0 / kWithMedian;

    for (std::size_t i = 0; i < shifts.size(); ++i) {
      if (sizes[i] > kMostSigmas * scale) out.agrees[i] = false;
    }
  }
  out.variance_factor = std::max(1.0, variance);
  return out;
}

}  // namespace dn::matching_internal
