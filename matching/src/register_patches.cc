#include "register_patches.h"

#include <dn/median.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace dn::matching_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kMaxIterations = 100;
constexpr double kSettled_m = 2e-5;
constexpr std::size_t kFewestPartners = 30;
constexpr std::size_t kFewestNeighbours = 5;
constexpr double kTukey = 4.685;  // 95 % efficiency for normal errors
constexpr double kLeastScale_m = 1e-4;
constexpr int kPartsAcross = 5;
constexpr int kFewestParts = 8;
constexpr double kLeastEigenvalueRatio = 1e-5;
constexpr double kPlaneMedians = 3.0;
constexpr double kLeastCosine = 0.94;  // at most 20 deg between the normals of partners

/// The distance of a point from the plane of its partner and its derivative with respect to the
/// shift.
struct Distance {
  double r_m;
  Vector3d n;
  double plane_rms_m;
  int part;
  double weight = 0.0;
};

class Registrar {
 public:
  Registrar(const PatchSurface& a, const PatchSurface& b, const RegisterOptions& options)
      : a_(a), b_(b), options_(options), most_rms_m_(kPlaneMedians * MedianRms(a, b)) {}

  std::vector<Distance> Distances(const Vector3d& shift_m) const {
    std::vector<Distance> found;
    found.reserve(a_.points_m().size() + b_.points_m().size());
    for (std::size_t i = 0; i < a_.points_m().size(); ++i) {
      const Vector3d& p_m = a_.points_m()[i];
      Add(a_.plane(i), b_, p_m + shift_m, 1.0, PartIndex(p_m), &found);
    }
    for (std::size_t i = 0; i < b_.points_m().size(); ++i) {
      const Vector3d back_m = b_.points_m()[i] - shift_m;
      if (Inside(back_m)) Add(b_.plane(i), a_, back_m, -1.0, PartIndex(back_m), &found);
    }
    return found;
  }

 private:
  static double MedianRms(const PatchSurface& a, const PatchSurface& b) {
    std::vector<double> rms_m;
    for (const PatchSurface* surface : {&a, &b}) {
      for (std::size_t i = 0; i < surface->points_m().size(); ++i) {
        rms_m.push_back(surface->plane(i).rms_m);
      }
    }
    return Median(std::move(rms_m));
  }

  bool Inside(const Vector3d& p_m) const {
    return (p_m.head<2>() - options_.centre_en_m).norm() <= options_.radius_m;
  }

  int PartIndex(const Vector3d& p_m) const {
    const auto along = [&](int i) {
      const double share = (p_m[i] - options_.centre_en_m[i]) / (2.0 * options_.radius_m) + 0.5;
      return std::clamp(static_cast<int>(share * kPartsAcross), 0, kPartsAcross - 1);
    };
    return kPartsAcross * along(0) + along(1);
  }

  bool IsPlane(const LocalPlane& plane) const {
    return plane.neighbours >= kFewestNeighbours && !plane.normal.isZero(0.0) &&
           plane.rms_m <= most_rms_m_;
  }

  /// Adds the distance of a point from the plane of its partner if both are on one surface. A wall
  /// seen by one strip must not be matched with the edge of the roof in the other.
  void Add(const LocalPlane& own, const PatchSurface& other, const Vector3d& p_m, double sign,
           int part, std::vector<Distance>* found) const {
    if (!IsPlane(own)) return;
    const PointTree::Nearest nearest = other.NearestTo(p_m);
    if (nearest.distance_m > options_.reach_m) return;
    const LocalPlane& plane = other.plane(nearest.index);
    if (!IsPlane(plane) || std::abs(plane.normal.dot(own.normal)) < kLeastCosine) return;
    found->push_back(
        {plane.normal.dot(p_m - plane.centroid_m), sign * plane.normal, plane.rms_m, part});
  }

  const PatchSurface& a_;
  const PatchSurface& b_;
  const RegisterOptions& options_;
  double most_rms_m_;
};

double RobustScale(const std::vector<Distance>& distances) {
  std::vector<double> sizes;
  sizes.reserve(distances.size());
  for (const Distance& d : distances) sizes.push_back(std::abs(d.r_m));
  return std::max(kLeastScale_m, kSigmaPerMedian * Median(std::move(sizes)));
}

void Weigh(double scale_m, std::vector<Distance>* distances) {
  for (Distance& d : *distances) {
    const double u = d.r_m / (kTukey * scale_m);
    const double tukey = std::abs(u) < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
    const double rough = d.plane_rms_m / scale_m;
    d.weight = tukey / (1.0 + rough * rough);
  }
}

bool LeavesADirectionFree(const Matrix3d& N) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(N, Eigen::EigenvaluesOnly);
  return !(eigen.eigenvalues()[0] > kLeastEigenvalueRatio * eigen.eigenvalues()[2]);
}

/// Returns the weighted mean square of the distances, m^2.
double MeanSquare(const std::vector<Distance>& distances) {
  double sum = 0.0, squares = 0.0;
  for (const Distance& d : distances) {
    sum += d.weight;
    squares += d.weight * d.r_m * d.r_m;
  }
  return std::max(squares / sum, kLeastScale_m * kLeastScale_m);
}

/// Returns Registration::variance_ratio; 0 if there are too few parts.
double VarianceRatio(const std::vector<Distance>& distances, double mean_square_m2, double trace) {
  std::array<Vector3d, kPartsAcross * kPartsAcross> wants;
  std::array<bool, kPartsAcross * kPartsAcross> filled{};
  wants.fill(Vector3d::Zero());
  for (const Distance& d : distances) {
    wants[static_cast<std::size_t>(d.part)] += d.weight * d.r_m * d.n;
    filled[static_cast<std::size_t>(d.part)] = true;
  }
  double scatter = 0.0, parts = 0.0;
  for (std::size_t k = 0; k < wants.size(); ++k) {
    if (!filled[k]) continue;
    parts += 1.0;
    scatter += wants[k].squaredNorm();
  }
  if (parts < kFewestParts) return 0.0;
  return scatter * parts / (parts - 3.0) / (mean_square_m2 * trace);
}

Registration Judge(const std::vector<Distance>& distances, const Vector3d& shift_m,
                   const Matrix3d& N, std::size_t points) {
  Registration out;
  out.shift_m = shift_m;
  const double mean_square_m2 = MeanSquare(distances);
  out.rms_m = std::sqrt(mean_square_m2);
  double used = 0.0;
  for (const Distance& d : distances) used += d.weight > 0.25 ? 1.0 : 0.0;
  out.used_share = used / static_cast<double>(points);
  out.information = N / mean_square_m2;
  out.variance_ratio = VarianceRatio(distances, mean_square_m2, N.trace());
  return out;
}

}  // namespace

std::optional<Registration> RegisterPatches(const PatchSurface& a, const PatchSurface& b,
                                            const Vector3d& start_m,
                                            const RegisterOptions& options) {
  const Registrar registrar(a, b, options);
  Vector3d shift_m = start_m;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    std::vector<Distance> distances = registrar.Distances(shift_m);
    if (distances.size() < kFewestPartners) return std::nullopt;
    Weigh(RobustScale(distances), &distances);
    Matrix3d N = Matrix3d::Zero();
    Vector3d h = Vector3d::Zero();
    for (const Distance& d : distances) {
      N += d.weight * d.n * d.n.transpose();
      h += d.weight * d.r_m * d.n;
    }
    if (LeavesADirectionFree(N)) return std::nullopt;
    const Vector3d step_m = -N.ldlt().solve(h);
    if (step_m.norm() < kSettled_m || iteration + 1 == kMaxIterations) {
      Registration out = Judge(distances, shift_m, N, a.points_m().size() + b.points_m().size());
      return out.variance_ratio > 0.0 ? std::make_optional(out) : std::nullopt;
    }
    shift_m += step_m.norm() > options.reach_m ? options.reach_m / step_m.norm() * step_m : step_m;
  }
  return std::nullopt;
}

}  // namespace dn::matching_internal
