#include "register_patches.h"

#include <dn/median.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace dn::matching_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Lengths in ground sampling distances.
// Standard deviations of a point of one strip about the surface of the other, beyond those of the
// neighbourhoods. The strips sample different places of it. They bound the weights only, because
// EstimateScales() finds the size of the differences.
constexpr double kLeastSigma_gsd = 0.15, kLeastSigmaPlane_gsd = 0.03;
// The quotient needs a step at which many points have new partners. It is half of a typical
// difference, but at least a quarter of the distance between the points.
constexpr double kQuotientStep = 0.5;  // in typical sigmas of a difference
constexpr double kLeastStep_gsd = 0.25, kLeastHeightStep_gsd = 0.05, kMostStep_gsd = 2.0;
constexpr double kLeastSignificance = 2.0;  // of the stiffness in its own sigmas
constexpr double kSettled_gsd = 2e-3;

constexpr int kGaussNewtonSteps = 5;
constexpr int kNewtonSteps = 6;
constexpr std::size_t kFewestPartners = 30;
constexpr double kFreedomOfT = 4.0;
constexpr double kMostSigmas = 5.0;
constexpr double kMedianOfChiSquare1 = 0.4549, kMedianOfChiSquare3 = 2.366;
constexpr double kLeastScale2 = 1e-6;
constexpr int kPartsAcross = 4;
constexpr int kFewestParts = 8;
constexpr double kLeastEigenvalueRatio = 1e-6;
constexpr double kLeastCosine = 0.94;  // at most 20 deg between the normals of partners

/// The difference of two points and its information matrix.
struct Difference {
  Vector3d d_m;
  Matrix3d W;
  bool planar;
  int part;
  Vector2d at_en_m;  ///< in strip a
};

/// Variances of the differences in units of their information matrices.
struct Scales {
  double planar = 1.0, volumetric = 1.0;
};

struct Score {
  Vector3d g = Vector3d::Zero();
  Matrix3d N = Matrix3d::Zero();             ///< stiffness with the partners kept
  Matrix3d N_volumetric = Matrix3d::Zero();  ///< its part from volumetric neighbourhoods
  Matrix3d scatter = Matrix3d::Zero();
  Vector2d moment = Vector2d::Zero();  ///< of the places, with their information of the height
  std::array<Vector3d, kPartsAcross * kPartsAcross> parts;
  std::array<bool, kPartsAcross * kPartsAcross> filled{};
};

class Registrar {
 public:
  Registrar(const PatchSurface& a, const PatchSurface& b, const Vector3d& start_m,
            const RegisterOptions& options)
      : a_(a), b_(b), options_(options) {
    from_a_ = Choose(a, Vector3d::Zero());
    from_b_ = Choose(b, start_m);
  }

  std::size_t points() const { return points_; }
  std::size_t used() const { return from_a_.size() + from_b_.size(); }

  std::vector<Difference> Differences(const Vector3d& shift_m) const {
    std::vector<Difference> found;
    found.reserve(from_a_.size() + from_b_.size());
    for (const std::size_t i : from_a_) {
      const Vector3d at_m = a_.points_m()[i] + shift_m;
      const PointTree::Nearest nearest = b_.NearestTo(at_m);
      if (nearest.distance_m > Reach()) continue;
      Add(a_.neighbourhood(i), a_.points_m()[i], b_.neighbourhood(nearest.index),
          b_.points_m()[nearest.index], shift_m, 1.0, a_.points_m()[i], &found);
    }
    for (const std::size_t i : from_b_) {
      const Vector3d at_m = b_.points_m()[i] - shift_m;
      const PointTree::Nearest nearest = a_.NearestTo(at_m);
      if (nearest.distance_m > Reach()) continue;
      Add(b_.neighbourhood(i), b_.points_m()[i], a_.neighbourhood(nearest.index),
          a_.points_m()[nearest.index], -shift_m, -1.0, at_m, &found);
    }
    return found;
  }

  double gsd_m() const { return options_.gsd_m; }

 private:
  double Reach() const { return kReach_gsd * options_.gsd_m; }

  /// Returns the points in the cell, evenly thinned.
  std::vector<std::size_t> Choose(const PatchSurface& patch, const Vector3d& shift_m) {
    std::vector<std::size_t> inside;
    for (std::size_t i = 0; i < patch.points_m().size(); ++i) {
      if (patch.neighbourhood(i).kind == Neighbourhood::Kind::kSparse) continue;
      if (options_.cell.Contains(patch.points_m()[i] - shift_m)) inside.push_back(i);
    }
    points_ += inside.size();
    const std::size_t n = std::min(inside.size(), options_.most_points);
    for (std::size_t k = 0; k < n; ++k) inside[k] = inside[k * inside.size() / n];
    inside.resize(n);
    return inside;
  }

  int PartIndex(const Vector3d& p_m) const {
    const auto along = [&](int i) {
      const double share =
          (p_m[i] - options_.cell.centre_en_m[i]) / (2.0 * options_.cell.half_m) + 0.5;
      return std::clamp(static_cast<int>(share * kPartsAcross), 0, kPartsAcross - 1);
    };
    return kPartsAcross * along(0) + along(1);
  }

  /// Adds the difference of a point and its partner at the place at_m of strip a.
  void Add(const Neighbourhood& own, const Vector3d& p_m, const Neighbourhood& other,
           const Vector3d& q_m, const Vector3d& shift_m, double sign, const Vector3d& at_m,
           std::vector<Difference>* found) const {
    if (other.kind == Neighbourhood::Kind::kSparse) return;
    if (own.planar() && other.planar() && std::abs(own.normal.dot(other.normal)) < kLeastCosine) {
      return;
    }
    const double s0_m = kLeastSigma_gsd * options_.gsd_m;
    if (!own.planar() && !other.planar()) {
      const Matrix3d C =
          own.covariance_m2 + other.covariance_m2 + s0_m * s0_m * Matrix3d::Identity();
      found->push_back(
          {sign * (p_m + shift_m - q_m), C.inverse(), false, PartIndex(at_m), at_m.head<2>()});
      return;
    }
    const double s0p_m = kLeastSigmaPlane_gsd * options_.gsd_m;
    const Vector3d& n = other.planar() ? other.normal : own.normal;
    const double variance_m2 = n.dot((own.covariance_m2 + other.covariance_m2) * n) + s0p_m * s0p_m;
    const Vector3d d_m = other.planar() ? Vector3d(p_m + shift_m - other.mean_m)
                                        : Vector3d(own.mean_m + shift_m - q_m);
    found->push_back(
        {sign * d_m, n * n.transpose() / variance_m2, true, PartIndex(at_m), at_m.head<2>()});
  }

  const PatchSurface& a_;
  const PatchSurface& b_;
  const RegisterOptions& options_;
  std::vector<std::size_t> from_a_, from_b_;
  std::size_t points_ = 0;
};

/// Returns robust scales from the medians of the squared differences.
Scales EstimateScales(const std::vector<Difference>& differences) {
  std::vector<double> planar, volumetric;
  for (const Difference& d : differences) {
    (d.planar ? planar : volumetric).push_back(d.d_m.dot(d.W * d.d_m));
  }
  Scales scales;
  if (!planar.empty()) {
    scales.planar = std::max(kLeastScale2, Median(std::move(planar)) / kMedianOfChiSquare1);
  }
  if (!volumetric.empty()) {
    scales.volumetric = std::max(kLeastScale2, Median(std::move(volumetric)) / kMedianOfChiSquare3);
  }
  return scales;
}

Score MakeScore(const std::vector<Difference>& differences, const Scales& scales) {
  Score score;
  score.parts.fill(Vector3d::Zero());
  for (const Difference& d : differences) {
    const double scale = d.planar ? scales.planar : scales.volumetric;
    const Vector3d Wd = d.W * d.d_m / scale;
    const double squared = d.d_m.dot(Wd);
    const double freedom = d.planar ? 1.0 : 3.0;
    if (squared > kMostSigmas * kMostSigmas) continue;
    const double weight = (kFreedomOfT + freedom) / (kFreedomOfT + squared);
    const Vector3d g = weight * Wd;
    score.g += g;
    score.N += weight / scale * d.W;
    if (!d.planar) score.N_volumetric += weight / scale * d.W;
    score.scatter += g * g.transpose();
    score.moment += weight / scale * d.W(2, 2) * d.at_en_m;
    score.parts[static_cast<std::size_t>(d.part)] += g;
    score.filled[static_cast<std::size_t>(d.part)] = true;
  }
  return score;
}

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
Matrix3d Stiffness(const Registrar& registrar, const Vector3d& shift_m, const Scales& scales,
                   const Vector3d& steps_m) {
  Matrix3d J;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d step_m = steps_m[axis] * Vector3d::Unit(axis);
    J.col(axis) = (MakeScore(registrar.Differences(shift_m + step_m), scales).g -
                   MakeScore(registrar.Differences(shift_m - step_m), scales).g) /
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
  const Registrar registrar(a, b, start_m, options);
  const double most_step_m = options.gsd_m;
  const auto limited = [&](const Vector3d& step_m) {
    return step_m.norm() > most_step_m ? Vector3d(most_step_m / step_m.norm() * step_m) : step_m;
  };
  const double settled_m = kSettled_gsd * options.gsd_m;
  Registration out;
  out.shift_m = start_m;
  out.points = registrar.points();
  out.used = registrar.used();
  Scales scales;
  Vector3d steps_m;
  for (int step = 0; step < kGaussNewtonSteps; ++step) {
    const std::vector<Difference> differences = registrar.Differences(out.shift_m);
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
    if (step % 3 == 0) out.stiffness = Stiffness(registrar, out.shift_m, scales, steps_m);
    const Score score = MakeScore(registrar.Differences(out.shift_m), scales);
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
