#include "agree_with_neighbours.h"

#include <dn/median.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "median_by_axis.h"

namespace dn::matching_internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kNeighbours = 8;
constexpr std::size_t kFewest = 4;
constexpr std::size_t kFewestForTrend = 8;
constexpr double kHuberOfTrend = 1.345;  // 95 % efficiency for normal errors
constexpr int kHuberIterations = 20;
constexpr double kMostSigmas = 3.5;
// Variance of the difference between a value and the median of eight others of the same accuracy.
constexpr double kWithMedian = 1.2;

/// Solves A x = value with Huber's weights and standard deviations proportional to sigma; their
/// scale is estimated from the median.
Vector3d FitByHuber(const Eigen::MatrixX3d& A, const Eigen::VectorXd& value,
                    const Eigen::VectorXd& sigma) {
  Vector3d x = Vector3d::Zero();
  Eigen::VectorXd weight = sigma.array().square().inverse();
  for (int iteration = 0; iteration < kHuberIterations; ++iteration) {
    const Eigen::MatrixX3d weighted = weight.asDiagonal() * A;
    x = (weighted.transpose() * A).ldlt().solve(weighted.transpose() * value);
    const Eigen::ArrayXd size = ((value - A * x).array() / sigma.array()).abs();
    const double scale = kSigmaPerMedian * Median({size.begin(), size.end()});
    if (!(scale > 0.0)) break;
    weight = (kHuberOfTrend * scale / size.max(kHuberOfTrend * scale)) / sigma.array().square();
  }
  return x;
}

/// Returns the shifts minus a plane over east and north, fitted per axis with Huber's weights. Such
/// a plane is the effect of a constant attitude error between two strips.
std::vector<PlacedShift> WithoutTrend(std::vector<PlacedShift> shifts) {
  if (shifts.size() < kFewestForTrend) return shifts;
  const auto n = static_cast<Eigen::Index>(shifts.size());
  Eigen::MatrixX3d A(n, 3);
  Vector2d centre_m = Vector2d::Zero();
  for (const PlacedShift& shift : shifts) centre_m += shift.at_en_m / static_cast<double>(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Vector2d at_m = shifts[static_cast<std::size_t>(k)].at_en_m - centre_m;
    A.row(k) << 1.0, at_m.x(), at_m.y();
  }
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd value(n), sigma(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const PlacedShift& shift = shifts[static_cast<std::size_t>(k)];
      value[k] = shift.shift_m[axis];
      sigma[k] = std::sqrt(shift.covariance_m2(axis, axis));
    }
    const Eigen::VectorXd left = value - A * FitByHuber(A, value, sigma);
    for (Eigen::Index k = 0; k < n; ++k) {
      shifts[static_cast<std::size_t>(k)].shift_m[axis] = left[k];
    }
  }
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
