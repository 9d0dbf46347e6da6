#include <dn/axis_rotations.h>
#include <dn/fit_rotation.h>
#include <dn/lidar/mounting_fit.h>
#include <dn/rotation.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr std::size_t kFewestVectors = 30;
constexpr double kLeverArmSigma_m = 3.0;
constexpr double kLeastRms_m = 1e-6;  // of exact points
constexpr double kLeastSecondAxis =
    1e-4;  // of the second axis of the vectors, relative to the first
constexpr int kSteps = 6;

/// Returns the rotation without a lever arm; nullopt if the vectors lie along one line.
std::optional<Matrix3d> AlignVectors(const std::vector<PointAndVector>& points) {
  Matrix3d sum = Matrix3d::Zero();
  for (const PointAndVector& point : points) sum += point.q_b_m * point.u_s_m.transpose();
  const RotationFit fit = FitRotation(sum);
  if (!(fit.singular_values[1] > kLeastSecondAxis * fit.singular_values[0])) return std::nullopt;
  return fit.R;
}

double Rms(const std::vector<PointAndVector>& points, const MountingFit& fit) {
  double squares_m2 = 0.0;
  for (const PointAndVector& point : points) {
    squares_m2 += (point.q_b_m - fit.R_bs * point.u_s_m - fit.lever_arm_b_m).squaredNorm();
  }
  return std::max(kLeastRms_m, std::sqrt(squares_m2 / (3.0 * static_cast<double>(points.size()))));
}

/// Improves rotation and lever arm by one step of Gauss-Newton.
void Improve(const std::vector<PointAndVector>& points, MountingFit* fit) {
  Matrix6d N = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  const double weight = 1.0 / (fit->rms_m * fit->rms_m);
  for (const PointAndVector& point : points) {
    const Vector3d u_b_m = fit->R_bs * point.u_s_m;
    Eigen::Matrix<double, 3, 6> J;
    J << -Skew(u_b_m), Matrix3d::Identity();
    const Vector3d r_m = point.q_b_m - u_b_m - fit->lever_arm_b_m;
    N += weight * J.transpose() * J;
    b += weight * J.transpose() * r_m;
  }
  const double prior = 1.0 / (kLeverArmSigma_m * kLeverArmSigma_m);
  N.bottomRightCorner<3, 3>().diagonal().array() += prior;
  b.tail<3>() -= prior * fit->lever_arm_b_m;
  const Eigen::LDLT<Matrix6d> factor(N);
  const Vector6d step = factor.solve(b);
  fit->R_bs = Exp(Vector3d(step.head<3>())) * fit->R_bs;
  fit->lever_arm_b_m += step.tail<3>();
  const Matrix6d covariance = factor.solve(Matrix6d::Identity());
  fit->lever_arm_sigma_m = covariance.diagonal().tail<3>().cwiseMax(0.0).cwiseSqrt();
  fit->rms_m = Rms(points, *fit);
}

}  // namespace

std::optional<MountingFit> FitMounting(const std::vector<PointAndVector>& points) {
  if (points.size() < kFewestVectors) return std::nullopt;
  const std::optional<Matrix3d> R_bs = AlignVectors(points);
  if (!R_bs) return std::nullopt;
  MountingFit fit;
  fit.R_bs = *R_bs;
  fit.rms_m = Rms(points, fit);
  for (int step = 0; step < kSteps; ++step) Improve(points, &fit);
  return fit;
}

Matrix3d NearestAxes(const Matrix3d& R) {
  // The trace of A^T R is 1 + 2 cos of the angle between the rotations A and R.
  return std::ranges::max(AxisRotations(), {},
                          [&](const Matrix3d& axes) { return axes.cwiseProduct(R).sum(); });
}

}  // namespace dn
