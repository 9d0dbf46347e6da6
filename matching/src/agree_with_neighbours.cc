#include "agree_with_neighbours.h"

#include <dn/median.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "median_by_axis.h"
#include "shift_trend.h"

namespace dn::matching_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kNeighbours = 8;
constexpr std::size_t kFewest = 4;
constexpr double kMostSigmas = 3.5;
// Variance of the median of normal values, relative to that of their mean.
constexpr double kMedianOverMean = std::numbers::pi / 2.0;
// A sample covariance of few residuals has unequal eigenvalues by chance. It is therefore averaged
// with that of so many residuals without a preferred direction.
constexpr double kIsotropicResiduals = 30.0;

/// Returns the shifts minus a plane over east and north. Such a plane is the effect of a constant
/// attitude error between two strips.
std::vector<PlacedShift> WithoutTrend(std::vector<PlacedShift> shifts) {
  const ShiftTrend trend = FitTrend(shifts);
  for (PlacedShift& shift : shifts) shift.shift_m -= trend.At(shift.at_en_m);
  return shifts;
}

/// The median of the shifts of the nearest neighbours, per axis.
struct MedianShift {
  Vector3d median_m;
  Vector3d variance_m2;
};

MedianShift NeighbourMedian(std::size_t i, const std::vector<PlacedShift>& shifts) {
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
  Vector3d sum_m2 = Vector3d::Zero();
  for (std::size_t k = 0; k < count; ++k) {
    nearest.push_back(shifts[others[k]].shift_m);
    sum_m2 += shifts[others[k]].covariance_m2.diagonal();
  }
  const auto n = static_cast<double>(count);
  return {MedianByAxis(nearest), kMedianOverMean / (n * n) * sum_m2};
}

/// Returns the covariance of residuals, pulled towards an isotropic one, with eigenvalues >= 1.
Matrix3d FitInflation(const Matrix3d& squares, double count) {
  const double isotropic = kIsotropicResiduals * squares.trace() / (3.0 * count);
  const Matrix3d F = (squares + isotropic * Matrix3d::Identity()) / (count + kIsotropicResiduals);
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(F);
  const Matrix3d& V = eigen.eigenvectors();
  return V * eigen.eigenvalues().cwiseMax(1.0).asDiagonal() * V.transpose();
}

/// A residual in units of its standard deviation.
struct Residual {
  Vector3d by_axis = Vector3d::Zero();
  Vector3d whitened = Vector3d::Zero();  ///< (C_i + C_median)^(-1/2) times the residual
};

Residual Normalise(const PlacedShift& shift, const MedianShift& neighbours) {
  const Vector3d left_m = shift.shift_m - neighbours.median_m;
  const Matrix3d median_m2 = neighbours.variance_m2.asDiagonal();
  const Matrix3d C = shift.covariance_m2 + median_m2;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(C);
  return {left_m.array() / C.diagonal().array().sqrt(), eigen.operatorInverseSqrt() * left_m};
}

}  // namespace

Matrix3d Agreement::Inflated(const Matrix3d& covariance_m2) const {
  const Matrix3d root = Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance_m2).operatorSqrt();
  return root * inflation * root;
}

Agreement AgreeWithNeighbours(const std::vector<PlacedShift>& given) {
  Agreement out;
  out.agrees.assign(given.size(), true);
  if (given.size() < kFewest) return out;
  const std::vector<PlacedShift> shifts = WithoutTrend(given);
  std::vector<Residual> left;
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    left.push_back(Normalise(shifts[i], NeighbourMedian(i, shifts)));
  }
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> sizes;
    for (const Residual& residual : left) sizes.push_back(std::abs(residual.by_axis[axis]));
    const double scale = std::max(1.0, kSigmaPerMedian * Median(sizes));
    for (std::size_t i = 0; i < shifts.size(); ++i) {
      if (sizes[i] > kMostSigmas * scale) out.agrees[i] = false;
    }
  }
  Matrix3d squares = Matrix3d::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    if (!out.agrees[i]) continue;
    squares += left[i].whitened * left[i].whitened.transpose();
    count += 1.0;
  }
  if (count == 0.0) return out;
  out.variance_factor = std::max(1.0, squares.trace() / (3.0 * count));
  out.inflation = FitInflation(squares, count);
  return out;
}

HeightAgreement AgreeInHeight(const std::vector<PlacedHeight>& given) {
  HeightAgreement out;
  out.agrees.assign(given.size(), true);
  if (given.size() < kFewest) return out;
  std::vector<PlacedShift> shifts;
  for (const PlacedHeight& height : given) {
    shifts.push_back({height.at_en_m, Vector3d(0.0, 0.0, height.shift_m),
                      Vector3d(1.0, 1.0, height.variance_m2).asDiagonal()});
  }
  shifts = WithoutTrend(std::move(shifts));
  std::vector<double> sizes;
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    sizes.push_back(std::abs(Normalise(shifts[i], NeighbourMedian(i, shifts)).by_axis.z()));
  }
  const double scale = std::max(1.0, kSigmaPerMedian * Median(sizes));
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    out.agrees[i] = sizes[i] <= kMostSigmas * scale;
    if (!out.agrees[i]) continue;
    sum += sizes[i] * sizes[i];
    count += 1.0;
  }
  if (count > 0.0) out.variance_factor = std::max(1.0, sum / count);
  return out;
}

}  // namespace dn::matching_internal
