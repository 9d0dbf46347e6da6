#include "shift_trend.h"

#include <dn/median.h>

#include <Eigen/Cholesky>
#include <cmath>

namespace dn::matching_internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kFewestForSlopes = 8;
constexpr double kHuber = 1.345;  // 95 % efficiency for normal errors
constexpr int kHuberIterations = 20;

/// Solves A x = value with Huber's weights and standard deviations proportional to sigma; their
/// scale is estimated from the median.
Eigen::VectorXd FitByHuber(const Eigen::MatrixXd& A, const Eigen::VectorXd& value,
                           const Eigen::VectorXd& sigma) {
  Eigen::VectorXd x;
  Eigen::VectorXd weight = sigma.array().square().inverse();
  for (int iteration = 0; iteration < kHuberIterations; ++iteration) {
    const Eigen::MatrixXd weighted = weight.asDiagonal() * A;
    x = (weighted.transpose() * A).ldlt().solve(weighted.transpose() * value);
    const Eigen::ArrayXd size = ((value - A * x).array() / sigma.array()).abs();
    const double scale = kSigmaPerMedian * Median({size.begin(), size.end()});
    if (!(scale > 0.0)) break;
    weight = (kHuber * scale / size.max(kHuber * scale)) / sigma.array().square();
  }
  return x;
}

Eigen::Index Unknowns(std::size_t shifts) { return shifts < kFewestForSlopes ? 1 : 3; }

}  // namespace

ShiftTrend FitTrend(const std::vector<PlacedShift>& shifts) {
  ShiftTrend trend;
  const auto n = static_cast<Eigen::Index>(shifts.size());
  for (const PlacedShift& shift : shifts) {
    trend.centre_en_m += shift.at_en_m / static_cast<double>(n);
  }
  const Eigen::Index unknowns = Unknowns(shifts.size());
  Eigen::MatrixXd A(n, unknowns);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Vector2d at_m = shifts[static_cast<std::size_t>(k)].at_en_m - trend.centre_en_m;
    A.row(k) = Vector3d(1.0, at_m.x(), at_m.y()).head(unknowns);
  }
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd value(n), sigma(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const PlacedShift& shift = shifts[static_cast<std::size_t>(k)];
      value[k] = shift.shift_m[axis];
      sigma[k] = std::sqrt(shift.covariance_m2(axis, axis));
    }
    trend.coefficients.row(axis).head(unknowns) = FitByHuber(A, value, sigma);
  }
  return trend;
}

Vector3d ScatterAbout(const ShiftTrend& trend, const std::vector<PlacedShift>& shifts) {
  Vector3d squares_m2 = Vector3d::Zero();
  for (const PlacedShift& shift : shifts) {
    squares_m2 += (shift.shift_m - trend.At(shift.at_en_m)).cwiseAbs2();
  }
  const auto freedom =
      static_cast<double>(shifts.size()) - static_cast<double>(Unknowns(shifts.size()));
  return (squares_m2 / freedom).cwiseSqrt();
}

}  // namespace dn::matching_internal
