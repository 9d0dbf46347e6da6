#include "patch_differences.h"

#include <dn/median.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace dn::matching_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Lengths in ground sampling distances.
// Standard deviations of a point of one strip about the surface of the other, beyond those of the
// neighbourhoods. The strips sample different places of it. They bound the weights only, because
// EstimateScales() finds the size of the differences.
constexpr double kLeastSigma_gsd = 0.15, kLeastSigmaPlane_gsd = 0.03;

constexpr double kFreedomOfT = 4.0;
constexpr double kMostSigmas = 5.0;
constexpr double kMedianOfChiSquare1 = 0.4549, kMedianOfChiSquare3 = 2.366;
constexpr double kLeastScale2 = 1e-6;
constexpr double kLeastCosine = 0.94;  // at most 20 deg between the normals of partners

}  // namespace

int PartIndex(const GroundCell& cell, const Vector3d& p_m) {
  const auto along = [&](int i) {
    const double share = (p_m[i] - cell.centre_en_m[i]) / (2.0 * cell.half_m) + 0.5;
    return std::clamp(static_cast<int>(share * kPartsAcross), 0, kPartsAcross - 1);
  };
  return kPartsAcross * along(0) + along(1);
}

PatchDifferences::PatchDifferences(const PatchSurface& a, const PatchSurface& b,
                                   const Vector3d& start_m, const RegisterOptions& options)
    : a_(a), b_(b), options_(options) {
  from_a_ = Choose(a, Vector3d::Zero());
  from_b_ = Choose(b, start_m);
}

std::vector<PointDifference> PatchDifferences::At(const Vector3d& shift_m) const {
  std::vector<PointDifference> found;
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

/// Returns the points in the cell, evenly thinned.
std::vector<std::size_t> PatchDifferences::Choose(const PatchSurface& patch,
                                                  const Vector3d& shift_m) {
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

/// Adds the difference of a point and its partner at the place at_m of strip a.
void PatchDifferences::Add(const Neighbourhood& own, const Vector3d& p_m,
                           const Neighbourhood& other, const Vector3d& q_m, const Vector3d& shift_m,
                           double sign, const Vector3d& at_m,
                           std::vector<PointDifference>* found) const {
  if (other.kind == Neighbourhood::Kind::kSparse) return;
  if (own.planar() && other.planar() && std::abs(own.normal.dot(other.normal)) < kLeastCosine) {
    return;
  }
  const double s0_m = kLeastSigma_gsd * options_.gsd_m;
  if (!own.planar() && !other.planar()) {
    const Matrix3d C = own.covariance_m2 + other.covariance_m2 + s0_m * s0_m * Matrix3d::Identity();
    found->push_back({sign * (p_m + shift_m - q_m), C.inverse(), false,
                      PartIndex(options_.cell, at_m), at_m.head<2>()});
    return;
  }
  const double s0p_m = kLeastSigmaPlane_gsd * options_.gsd_m;
  const Vector3d& n = other.planar() ? other.normal : own.normal;
  const double variance_m2 = n.dot((own.covariance_m2 + other.covariance_m2) * n) + s0p_m * s0p_m;
  const Vector3d d_m = other.planar() ? Vector3d(p_m + shift_m - other.mean_m)
                                      : Vector3d(own.mean_m + shift_m - q_m);
  found->push_back({sign * d_m, n * n.transpose() / variance_m2, true,
                    PartIndex(options_.cell, at_m), at_m.head<2>()});
}

Scales EstimateScales(const std::vector<PointDifference>& differences) {
  std::vector<double> planar, volumetric;
  for (const PointDifference& d : differences) {
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

Score MakeScore(const std::vector<PointDifference>& differences, const Scales& scales) {
  Score score;
  score.parts.fill(Vector3d::Zero());
  for (const PointDifference& d : differences) {
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

}  // namespace dn::matching_internal
