#pragma once

#include <dn/sim/terrain_caster.h>

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "laser_ray.h"
#include "ray_stretch.h"

namespace dn {

/// A plant: a vertical trunk, and a crown of leaf clusters that lets light through. The crown is
/// divided into cubes. A cube contains a sphere (a cluster of leaves or needles) or is empty. Which
/// cubes have one, where and how large, depends only on the seed and the cube, so that every strip
/// sees the same plant. Clusters are in groups, with gaps between them.
struct Plant {
  enum class Crown { kCone, kEllipsoid };

  Eigen::Vector3d foot_m = Eigen::Vector3d::Zero();  ///< foot of the trunk on the ground, frame m
  double height_m = 0.0;
  double crown_base_m = 0.0;  ///< height of the lowest leaves above the foot
  double radius_m = 0.0;      ///< largest radius of the crown
  double trunk_radius_m = 0.0;
  double cell_m = 0.0;      ///< edge of the cubes
  double leaf_share = 0.0;  ///< fraction of the cubes at the edge of the crown that have leaves
  Crown crown = Crown::kEllipsoid;
  std::uint64_t seed = 0;

  /// Returns the first leaf cluster or trunk that a ray meets. It begins within the stretch; leaves
  /// in the last cube may lie beyond it.
  std::optional<RayHit> FirstHit(const LaserRay& ray, const Stretch& within) const;

 private:
  std::optional<RayHit> FirstLeaf(const Eigen::Vector3d& start_m, const Eigen::Vector3d& direction,
                                  double length_m) const;
  // Returns the random number of the leaf cluster in a cube; nullopt if the cube is empty.
  std::optional<std::uint64_t> LeafHash(const Eigen::Vector3i& cube,
                                        const Eigen::Vector3d& middle_m) const;
  std::optional<RayHit> LeafIn(const Eigen::Vector3i& cube, const Eigen::Vector3d& start_m,
                               const Eigen::Vector3d& direction) const;
  std::optional<RayHit> Trunk(const LaserRay& ray, double aside_m, const Stretch& within) const;
  // Returns (distance from the axis / radius of the crown)^2 at a place from the foot.
  double Outwards(const Eigen::Vector3d& at_m) const;
};

}  // namespace dn
