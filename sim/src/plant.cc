#include "plant.h"

#include <dn/sim/random.h>

#include <array>
#include <cmath>

namespace dn {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kHighPlant_m = 2.0;  // lower leaves are low vegetation
constexpr double kTrunkShare = 0.7;   // part of the height that the trunk reaches
// Groups of 2 x 2 x 2 cubes: this fraction of them may contain leaves.
constexpr double kGroups = 0.85;
// Leaves are sparser on the axis of the crown than at its edge, where light is.
constexpr double kLeavesOnAxis = 0.7;

std::uint64_t CubeKey(const Vector3i& cube) {
  constexpr int kBits = 21, kMask = (1 << kBits) - 1;
  std::uint64_t key = 0;
  for (const int part : {cube.x(), cube.y(), cube.z()}) {
    key = key << kBits | static_cast<std::uint64_t>(part & kMask);
  }
  return key;
}

/// Returns 16 bits of a hash as a number in [0, 1).
double HashPart(std::uint64_t hash, int part) {
  return static_cast<double>((hash >> (16 * part)) & 0xffff) * 0x1.0p-16;
}

/// Steps along a ray from cube to cube.
class CubeWalk {
 public:
  CubeWalk(const Vector3d& start_m, const Vector3d& direction, double cell_m) {
    for (int k = 0; k < 3; ++k) {
      cube_[k] = static_cast<int>(std::floor(start_m[k] / cell_m));
      step_[k] = direction[k] < 0.0 ? -1 : 1;
      const double border_m = (cube_[k] + (step_[k] > 0 ? 1 : 0)) * cell_m;
      const bool moves = direction[k] != 0.0;
      spacing_m_[k] = moves ? cell_m / std::abs(direction[k]) : Stretch::kNowhere;
      exit_m_[k] = moves ? (border_m - start_m[k]) / direction[k] : Stretch::kNowhere;
    }
  }

  const Vector3i& cube() const { return cube_; }

  /// Goes to the next cube and returns the range at which the ray enters it.
  double Next() {
    int k = exit_m_[0] < exit_m_[1] ? 0 : 1;
    if (exit_m_[2] < exit_m_[k]) k = 2;
    const double entered_m = exit_m_[k];
    exit_m_[k] += spacing_m_[k];
    cube_[k] += step_[k];
    return entered_m;
  }

 private:
  Vector3i cube_, step_;
  Vector3d exit_m_, spacing_m_;
};

}  // namespace

double Plant::Outwards(const Vector3d& at_m) const {
  const double length_m = height_m - crown_base_m;
  const double up = (at_m.z() - crown_base_m) / length_m;  // 0 at the base, 1 at the top
  if (up < 0.0 || up > 1.0) return Stretch::kNowhere;
  const double narrow = crown == Crown::kCone ? (1.0 - up) * (1.0 - up) : 4.0 * up * (1.0 - up);
  return at_m.head<2>().squaredNorm() / (radius_m * radius_m * narrow + 1e-9);
}

std::optional<std::uint64_t> Plant::LeafHash(const Vector3i& cube, const Vector3d& middle_m) const {
  const Vector3i group(cube.x() >> 1, cube.y() >> 1, cube.z() >> 1);
  if (HashPart(MixBits(~seed ^ CubeKey(group)), 0) >= kGroups) return std::nullopt;
  const std::uint64_t hash = MixBits(seed ^ CubeKey(cube));
  const double chance = HashPart(hash, 0) * kGroups / leaf_share;
  if (chance >= 1.0) return std::nullopt;
  const double outwards = Outwards(middle_m);
  if (outwards > 1.0) return std::nullopt;
  if (chance >= kLeavesOnAxis + (1.0 - kLeavesOnAxis) * outwards) return std::nullopt;
  return hash;
}

std::optional<RayHit> Plant::LeafIn(const Vector3i& cube, const Vector3d& start_m,
                                    const Vector3d& direction) const {
  const Vector3d middle_m = (cube.cast<double>() + Vector3d::Constant(0.5)) * cell_m;
  const auto hash = LeafHash(cube, middle_m);
  if (!hash) return std::nullopt;
  const double leaf_m = cell_m * (0.25 + 0.25 * HashPart(*hash, 1));
  const Vector3d off(HashPart(*hash, 2) - 0.5, HashPart(*hash, 3) - 0.5,
                     HashPart(MixBits(*hash), 0) - 0.5);
  const Vector3d to_leaf_m = middle_m + (cell_m - 2.0 * leaf_m) * off - start_m;
  const double closest_m = to_leaf_m.dot(direction);
  const double inside2 = leaf_m * leaf_m - (closest_m * direction - to_leaf_m).squaredNorm();
  if (inside2 <= 0.0) return std::nullopt;
  const double half_chord_m = std::sqrt(inside2);
  const Surface surface = middle_m.z() < kHighPlant_m ? Surface::kLowPlant : Surface::kHighPlant;
  return RayHit{closest_m - half_chord_m, surface, half_chord_m / leaf_m};
}

/// `start_m` is relative to the foot; the range of the result counts from it.
std::optional<RayHit> Plant::FirstLeaf(const Vector3d& start_m, const Vector3d& direction,
                                       double length_m) const {
  CubeWalk walk(start_m, direction, cell_m);
  double entered_m = 0.0;
  while (entered_m <= length_m) {
    const auto hit = LeafIn(walk.cube(), start_m, direction);
    if (hit && hit->range_m >= 0.0) return hit;
    entered_m = walk.Next();
  }
  return std::nullopt;
}

std::optional<RayHit> Plant::Trunk(const LaserRay& ray, double aside_m,
                                   const Stretch& within) const {
  const double inside2 = trunk_radius_m * trunk_radius_m - aside_m * aside_m;
  if (inside2 <= 0.0 || ray.across == 0.0) return std::nullopt;
  const double half_chord_m = std::sqrt(inside2);
  const double along_m = ray.heading.dot(foot_m.head<2>() - ray.origin_m.head<2>());
  const double range_m = (along_m - half_chord_m) / ray.across;
  const double up_m = ray.Height(range_m) - foot_m.z();
  const bool on_trunk = up_m > 0.0 && up_m < kTrunkShare * height_m;
  if (!on_trunk || range_m < within.from_m || range_m > within.to_m) return std::nullopt;
  return RayHit{range_m, Surface::kHighPlant, ray.across * half_chord_m / trunk_radius_m};
}

std::optional<RayHit> Plant::FirstHit(const LaserRay& ray, const Stretch& within) const {
  const double aside_m = ray.Aside(foot_m.head<2>());
  const double chord2 = radius_m * radius_m - aside_m * aside_m;
  if (chord2 < 0.0) return std::nullopt;
  Stretch over{std::max(within.from_m, ray.RangeAtHeight(foot_m.z() + height_m)),
               std::min(within.to_m, ray.RangeAtHeight(foot_m.z() + crown_base_m))};
  const double along_m = ray.heading.dot(ray.origin_m.head<2>() - foot_m.head<2>());
  over = over.Within(along_m, ray.across, std::sqrt(chord2));
  const auto trunk = Trunk(ray, aside_m, within);
  if (over.empty()) return trunk;
  auto leaf = FirstLeaf(ray.At(over.from_m) - foot_m, ray.direction, over.to_m - over.from_m);
  if (!leaf) return trunk;
  leaf->range_m += over.from_m;
  return trunk && trunk->range_m < leaf->range_m ? trunk : leaf;
}

}  // namespace dn
