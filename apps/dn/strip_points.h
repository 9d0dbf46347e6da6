#pragma once

#include <dn/geo/point_crs.h>
#include <dn/lidar/mounting_fit.h>

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "rough_path.h"

namespace dn::apps {

/// Some points of all strips of a scanner.
struct StripPoints {
  std::vector<double> t_s;
  std::vector<Eigen::Vector3d> p_c;
  std::vector<Eigen::Vector3d> u_s;  ///< empty if a strip lacks them
  bool has_vectors = true;
  std::string crs;      ///< stated by the files
  double points = 0.0;  ///< number before sampling
};

/// Returns every seventh of the first 100,000 points of each strip that can be read. The commands
/// that use strips report the others.
StripPoints TakeStripPoints(const std::vector<std::filesystem::path>& strips);

/// The points in body axes, with their laser vectors if they have some.
struct PlacedPoints {
  std::vector<PointAndVector> points;
  std::vector<Eigen::Vector3d> p_m;
};

/// Places every `step`-th point about the path. Points without a pose or outside of the system are
/// left out.
PlacedPoints PlaceAbout(const RoughPath& path, const PointCrs& crs, const StripPoints& sample,
                        std::size_t step);

/// Returns the system in which the points lie about the path: the one that the files state, or one
/// of the guesses. Returns nullopt if there is none.
std::optional<PointCrs> FindPointCrs(const RoughPath& path, const StripPoints& sample,
                                     std::vector<std::string> guesses);

}  // namespace dn::apps
