#include "register_patches.h"

#include <dn/median.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace dn::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kMaxIterations = 30;
constexpr double kSettled_m = 1e-4;
constexpr std::size_t kFewestPartners = 30;
constexpr std::size_t kFewestNeighbours = 5;
constexpr double kTukey = 4.685;  // 95 % efficiency for normal errors
constexpr double kLeastScale_m = 1e-4;
constexpr int kPartsAcross = 5;
constexpr int kFewestParts = 8;
constexpr double kLeastEigenvalueRatio = 1e-4;

/// The distance of a point from the plane of its partner, and how it changes with the shift.
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
      : a_(a), b_(b), options_(options) {}

  std::vector<Distance> Distances(const Vector3d& shift_m) const {
    std::vector<Distance> found;
    found.reserve(a_.points_m().size() + b_.points_m().size());
    for (const Vector3d& p_m : a_.points_m()) Add(b_, p_m + shift_m, 1.0, PartOf(p_m), &found);
    for (const Vector3d& p_m : b_.points_m()) {
      const Vector3d back_m = p_m - shift_m;
      if (Inside(back_m)) Add(a_, back_m, -1.0, PartOf(back_m), &found);
    }
    return found;
  }

 private:
  bool Inside(const Vector3d& p_m) const {
    return (p_m.head<2>() - options_.centre_en_m).norm() <= options_.radius_m;
  }

  int PartOf(const Vector3d& p_m) const {
    const auto along = [&](int i) {
      const double share = (p_m[i] - options_.centre_en_m[i]) / (2.0 * options_.radius_m) + 0.5;
      return std::clamp(static_cast<int>(share * kPartsAcross), 0, kPartsAcross - 1);
    };
    return kPartsAcross * along(0) + along(1);
  }

  void Add(const PatchSurface& other, const Vector3d& p_m, double sign, int part,
           std::vector<Distance>* found) const {
    const PatchSurface::Nearest nearest = other.NearestTo(p_m);
    if (nearest.distance_m > options_.reach_m) return;
    const LocalPlane& plane = other.plane(nearest.index);
    if (plane.neighbours < kFewestNeighbours || plane.normal.isZero(0.0)) return;
    found->push_back(
        {plane.normal.dot(p_m - plane.centroid_m), sign * plane.normal, plane.rms_m, part});
  }

  const PatchSurface& a_;
  const PatchSurface& b_;
  const RegisterOptions& options_;
};

double RobustScale(const std::vector<Distance>& distances) {
  std::vector<double> sizes;
  sizes.reserve(distances.size());
  for (const Distance& d : distances) sizes.push_back(std::abs(d.r_m));
  return std::max(kLeastScale_m, kSigmaOfMedian * Median(std::move(sizes)));
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

Registration Judge(const std::vector<Distance>& distances, const Vector3d& shift_m,
                   const Matrix3d& N, std::size_t points) {
  Registration out;
  out.shift_m = shift_m;
  out.normal = N;
  std::array<Vector3d, kPartsAcross * kPartsAcross> wants;
  std::array<double, kPartsAcross * kPartsAcross> weights{};
  wants.fill(Vector3d::Zero());
  double sum = 0.0, squares = 0.0, used = 0.0;
  for (const Distance& d : distances) {
    wants[static_cast<std::size_t>(d.part)] += d.weight * d.r_m * d.n;
    weights[static_cast<std::size_t>(d.part)] += d.weight;
    sum += d.weight;
    squares += d.weight * d.r_m * d.r_m;
    if (d.weight > 0.25) used += 1.0;
  }
  out.rms_m = std::sqrt(squares / sum);
  out.used_share = used / static_cast<double>(points);
  const Matrix3d inverse = N.inverse();
  out.independent_m2 = out.rms_m * out.rms_m * inverse;
  Matrix3d scatter = Matrix3d::Zero();
  int parts = 0;
  for (std::size_t k = 0; k < wants.size(); ++k) {
    if (weights[k] <= 0.0) continue;
    ++parts;
    scatter += wants[k] * wants[k].transpose();
  }
  if (parts < kFewestParts) return out;
  out.clustered_m2 = inverse * scatter * inverse * parts / (parts - 3.0);
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
      return out.clustered_m2.isZero(0.0) ? std::nullopt : std::make_optional(out);
    }
    shift_m += step_m.norm() > options.reach_m ? options.reach_m / step_m.norm() * step_m : step_m;
  }
  return std::nullopt;
}

}  // namespace dn::internal
