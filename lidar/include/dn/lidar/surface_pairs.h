#pragma once

#include <dn/lidar/pairs.h>

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace dn {

/// Two points on one smooth surface, measured at two epochs. On a road or a field there is no
/// feature that identifies a point. Only the distance of the two points along the normal of the
/// surface is observed:
///
///   n^T (x_i - x_j) ~ N(0, sigma^2)
struct SurfacePair {
  LidarPair ends;                                       ///< without covariance
  Eigen::Vector3d normal_m = Eigen::Vector3d::UnitZ();  ///< unit normal n, map axes
  double sigma_m = 0.0;
};

/// Surface pairs of a flight and the files that contain them.
struct SurfacePairData {
  std::vector<std::filesystem::path> files;
  std::vector<SurfacePair> pairs;
  long repeated_pairs_dropped = 0;
};

/// Reads the files of surface pairs that match the glob patterns (relative to `folder`), sorted by
/// name. The columns are t_i, t_j, u_i (3), u_j (3), the normal (3, any length) and sigma_m. As in
/// ReadPairs, `time_offset_s` is subtracted from the epochs, and repeated pairs are dropped.
///
/// Throws InvalidInput with file:line if a time is not a second of week, or a vector is shorter
/// than 1 mm or longer than 50 km. Also throws if a normal has no length, or a sigma is not between
/// 1e-6 and 1e3 m. The same holds if a pattern matches no file.
SurfacePairData ReadSurfacePairs(const std::filesystem::path& folder,
                                 const std::vector<std::string>& patterns,
                                 double time_offset_s = 0.0);

/// Returns the text of a file of surface pairs, with up to 17 significant digits. The first line
/// states the origin of computed vectors.
std::string FormatSurfacePairs(const std::vector<SurfacePair>& pairs,
                               const VectorOrigin& origin = {});

}  // namespace dn
