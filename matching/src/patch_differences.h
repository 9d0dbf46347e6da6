#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "patch_surface.h"
#include "register_patches.h"

namespace dn::matching_internal {

/// A cell consists of 4 by 4 parts, for its variance ratio.
inline constexpr int kPartsAcross = 4;

/// Returns the index of the part of a cell that contains a place, or of the nearest one.
int PartIndex(const GroundCell& cell, const Eigen::Vector3d& p_m);

/// The difference of two points and its information matrix.
struct PointDifference {
  Eigen::Vector3d d_m;
  Eigen::Matrix3d W;
  bool planar;
  int part;                 ///< of the cell
  Eigen::Vector2d at_en_m;  ///< in strip a
};

/// Finds the differences of the points in a cell and their partners in the other strip. See
/// RegisterPatches.
class PatchDifferences {
 public:
  /// The patches and options must outlive the object.
  PatchDifferences(const PatchSurface& a, const PatchSurface& b, const Eigen::Vector3d& start_m,
                   const RegisterOptions& options);

  std::size_t points() const { return points_; }
  std::size_t used() const { return from_a_.size() + from_b_.size(); }

  std::vector<PointDifference> At(const Eigen::Vector3d& shift_m) const;

 private:
  double Reach() const { return kReach_gsd * options_.gsd_m; }
  std::vector<std::size_t> Choose(const PatchSurface& patch, const Eigen::Vector3d& shift_m);
  void Add(const Neighbourhood& own, const Eigen::Vector3d& p_m, const Neighbourhood& other,
           const Eigen::Vector3d& q_m, const Eigen::Vector3d& shift_m, double sign,
           const Eigen::Vector3d& at_m, std::vector<PointDifference>* found) const;

  const PatchSurface& a_;
  const PatchSurface& b_;
  const RegisterOptions& options_;
  std::vector<std::size_t> from_a_, from_b_;
  std::size_t points_ = 0;
};

/// Variances of the differences in units of their information matrices.
struct Scales {
  double planar = 1.0, volumetric = 1.0;
};

/// Returns robust scales from the medians of the squared differences.
Scales EstimateScales(const std::vector<PointDifference>& differences);

struct Score {
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();             ///< stiffness with the partners kept
  Eigen::Matrix3d N_volumetric = Eigen::Matrix3d::Zero();  ///< its part from volumes
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  /// Sum of the places, with their information of the height.
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  std::array<Eigen::Vector3d, kPartsAcross * kPartsAcross> parts;
  std::array<bool, kPartsAcross * kPartsAcross> filled{};
};

/// Returns the score of the differences, with the weights of Student's t distribution.
Score MakeScore(const std::vector<PointDifference>& differences, const Scales& scales);

/// Fewest parts of a cell that have points, for its variance ratio.
inline constexpr int kFewestParts = 8;
inline constexpr std::size_t kFewestPartners = 30;

}  // namespace dn::matching_internal
