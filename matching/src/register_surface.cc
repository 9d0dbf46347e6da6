#include "register_surface.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "patch_differences.h"

namespace dn::matching_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kSteps = 20;
// The last step is smaller than these parts of the sigma or of the distance between the points.
constexpr double kSettledSigma = 0.1, kSettledStep_gsd = 1e-5;
constexpr double kMostVolumetricShare = 0.1;  // of the information along the normal
constexpr double kQuotientStep_gsd = 0.05;

/// Returns the direction with the most information, upward.
Vector3d FindNormal(const Matrix3d& N) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(N);
  return Upward(eigen.eigenvectors().col(2));
}

bool IsSmooth(const Score& score, const Vector3d& normal) {
  return normal.z() > kLeastUp && normal.dot(score.N_volumetric * normal) <=
                                      kMostVolumetricShare * normal.dot(score.N * normal);
}

/// Returns SurfaceRegistration::variance_ratio; nullopt if there are too few parts.
std::optional<double> VarianceRatio(const Score& score, const Vector3d& normal) {
  double sum = 0.0, parts = 0.0;
  for (std::size_t k = 0; k < score.parts.size(); ++k) {
    if (!score.filled[k]) continue;
    parts += 1.0;
    sum += std::pow(normal.dot(score.parts[k]), 2);
  }
  if (parts < kFewestParts) return std::nullopt;
  return sum * parts / (parts - 1.0) / normal.dot(score.scatter * normal);
}

/// Returns the stiffness along the normal, a difference quotient with new partners.
double StiffnessAlong(const Vector3d& normal, const PatchDifferences& differences_at,
                      const Vector3d& shift_m, const Scales& scales, double step_m) {
  const Vector3d change = MakeScore(differences_at.At(shift_m + step_m * normal), scales).g -
                          MakeScore(differences_at.At(shift_m - step_m * normal), scales).g;
  return normal.dot(change) / (2.0 * step_m);
}

/// The score at the present shift, and the next step along the normal.
struct Step {
  Scales scales;
  Score score;
  double length_m = 0.0;
  double sigma_m = 0.0;  ///< of the shift, if the differences are independent
};

/// Sets the normal of the registration. Returns nullopt if the patches are not smooth there.
std::optional<Step> NextStep(const PatchDifferences& differences_at, SurfaceRegistration* out) {
  const std::vector<PointDifference> differences = differences_at.At(out->shift_m);
  if (differences.size() < kFewestPartners) return std::nullopt;
  Step step;
  step.scales = EstimateScales(differences);
  step.score = MakeScore(differences, step.scales);
  const Vector3d n = FindNormal(step.score.N);
  if (!IsSmooth(step.score, n)) return std::nullopt;
  out->normal_m = n;
  const double stiffness = n.dot(step.score.N * n);
  step.length_m = -n.dot(step.score.g) / stiffness;
  step.sigma_m = std::sqrt(n.dot(step.score.scatter * n)) / stiffness;
  return step;
}

}  // namespace

std::optional<SurfaceRegistration> RegisterSurface(const PatchSurface& a, const PatchSurface& b,
                                                   const Vector3d& start_m,
                                                   const RegisterOptions& options) {
  const PatchDifferences differences_at(a, b, start_m, options);
  const double gsd_m = options.gsd_m;
  SurfaceRegistration out;
  out.shift_m = start_m;
  for (int k = 0; k < kSteps; ++k) {
    const std::optional<Step> step = NextStep(differences_at, &out);
    if (!step) return std::nullopt;
    const double settled_m = std::max(kSettledSigma * step->sigma_m, kSettledStep_gsd * gsd_m);
    if (std::abs(step->length_m) > settled_m) {
      out.shift_m += std::clamp(step->length_m, -gsd_m, gsd_m) * out.normal_m;
      continue;
    }
    const std::optional<double> ratio = VarianceRatio(step->score, out.normal_m);
    if (!ratio) return std::nullopt;
    out.variance_ratio = *ratio;
    out.stiffness = StiffnessAlong(out.normal_m, differences_at, out.shift_m, step->scales,
                                   kQuotientStep_gsd * gsd_m);
    out.scatter = out.normal_m.dot(step->score.scatter * out.normal_m);
    out.centre_en_m = step->score.moment / step->score.N(2, 2);
    if (out.stiffness > 0.0) return out;
    return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace dn::matching_internal
