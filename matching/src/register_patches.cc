#include "register_patches.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "patch_differences.h"

namespace dn::matching_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Lengths in ground sampling distances.
// The quotient needs a step at which many points have new partners. It is half of a typical
// difference, but at least a quarter of the distance between the points.
constexpr double kQuotientStep = 0.5;  // in typical sigmas of a difference
constexpr double kLeastStep_gsd = 0.25, kLeastHeightStep_gsd = 0.05, kMostStep_gsd = 2.0;
constexpr double kLeastSignificance = 2.0;  // of the stiffness in its own sigmas

constexpr double kSettled_gsd = 2e-3;  // a smaller step ends an iteration

constexpr int kGaussNewtonSteps = 5;
constexpr int kNewtonSteps = 6;
constexpr double kLeastEigenvalueRatio = 1e-6;

bool LeavesADirectionFree(const Matrix3d& N) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(N, Eigen::EigenvaluesOnly);
  return !(eigen.eigenvalues()[0] > kLeastEigenvalueRatio * eigen.eigenvalues()[2]);
}

/// Returns steps along the axes for which a typical difference changes by a part of its sigma.
Vector3d QuotientSteps(const Score& score, double points, double gsd_m) {
  const Vector3d sigma_m = (points / score.N.diagonal().array()).sqrt();
  const Vector3d least_m(kLeastStep_gsd * gsd_m, kLeastStep_gsd * gsd_m,
                         kLeastHeightStep_gsd * gsd_m);
  return (kQuotientStep * sigma_m).cwiseMax(least_m).cwiseMin(kMostStep_gsd * gsd_m);
}

/// Returns the derivative of the score with new partners at each place.
Matrix3d Stiffness(const PatchDifferences& differences_at, const Vector3d& shift_m,
                   const Scales& scales, const Vector3d& steps_m) {
  Matrix3d J;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d step_m = steps_m[axis] * Vector3d::Unit(axis);
    J.col(axis) = (MakeScore(differences_at.At(shift_m + step_m), scales).g -
                   MakeScore(differences_at.At(shift_m - step_m), scales).g) /
                  (2.0 * steps_m[axis]);
  }
  return J;
}

/// Returns whether the stiffness of every direction is significant. The scores at both ends of a
/// step have independent errors, because the points have other partners there.
bool IsSignificant(const Matrix3d& stiffness, const Matrix3d& scatter, const Vector3d& steps_m) {
  const Matrix3d symmetric = 0.5 * (stiffness + stiffness.transpose());
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(symmetric);
  for (int k = 0; k < 3; ++k) {
    const Vector3d v = eigen.eigenvectors().col(k);
    const double step_m = v.cwiseProduct(steps_m).norm();
    const double sigma = std::sqrt(2.0 * v.dot(scatter * v)) / (2.0 * step_m);
    if (!(eigen.eigenvalues()[k] > kLeastSignificance * sigma)) return false;
  }
  return true;
}

/// Returns Registration::variance_ratio; 0 if there are too few parts.
double VarianceRatio(const Score& score) {
  const Eigen::LDLT<Matrix3d> scatter(score.scatter);
  double sum = 0.0, parts = 0.0;
  for (std::size_t k = 0; k < score.parts.size(); ++k) {
    if (!score.filled[k]) continue;
    parts += 1.0;
    sum += score.parts[k].dot(scatter.solve(score.parts[k]));
  }
  if (parts < kFewestParts) return 0.0;
  return sum * parts / (parts - 3.0) / 3.0;
}

}  // namespace

std::optional<Registration> RegisterPatches(const PatchSurface& a, const PatchSurface& b,
                                            const Vector3d& start_m,
                                            const RegisterOptions& options) {
  const PatchDifferences differences_at(a, b, start_m, options);
  const double most_step_m = options.gsd_m;
  const auto limited = [&](const Vector3d& step_m) {
    return step_m.norm() > most_step_m ? Vector3d(most_step_m / step_m.norm() * step_m) : step_m;
  };
  const double settled_m = kSettled_gsd * options.gsd_m;
  Registration out;
  out.shift_m = start_m;
  out.points = differences_at.points();
  out.used = differences_at.used();
  Scales scales;
  Vector3d steps_m;
  for (int step = 0; step < kGaussNewtonSteps; ++step) {
    const std::vector<PointDifference> differences = differences_at.At(out.shift_m);
    if (differences.size() < kFewestPartners) return std::nullopt;
    scales = EstimateScales(differences);
    const Score score = MakeScore(differences, scales);
    if (LeavesADirectionFree(score.N)) return std::nullopt;
    steps_m = QuotientSteps(score, static_cast<double>(differences.size()), options.gsd_m);
    const Vector3d step_m = -score.N.ldlt().solve(score.g);
    out.shift_m += limited(step_m);
    if (step_m.norm() < settled_m) break;
  }
  for (int step = 0; step < kNewtonSteps; ++step) {
    if (step % 3 == 0) out.stiffness = Stiffness(differences_at, out.shift_m, scales, steps_m);
    const Score score = MakeScore(differences_at.At(out.shift_m), scales);
    out.scatter = score.scatter;
    out.centre_en_m = score.moment / score.N(2, 2);
    out.volumetric_share = score.N.ldlt().solve(score.N_volumetric);
    out.variance_ratio = VarianceRatio(score);
    if (out.variance_ratio == 0.0) return std::nullopt;
    if (!IsSignificant(out.stiffness, std::max(1.0, out.variance_ratio) * out.scatter, steps_m)) {
      return std::nullopt;
    }
    const Vector3d step_m = -out.stiffness.inverse() * score.g;
    const double sigma_m = std::sqrt(out.Covariance(1.0).trace());
    if (step_m.norm() < std::max(settled_m, 0.1 * sigma_m)) return out;
    out.shift_m += limited(step_m);
  }
  return std::nullopt;
}

}  // namespace dn::matching_internal
