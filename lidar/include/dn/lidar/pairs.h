#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// A point-to-point correspondence: one ground point seen at two epochs.
struct LidarPair {
  double t_i_s = 0.0;
  double t_j_s = 0.0;
  Eigen::Vector3d u_i_s = Eigen::Vector3d::Zero();  ///< laser vector at t_i in the sensor frame, m
  Eigen::Vector3d u_j_s = Eigen::Vector3d::Zero();
  std::optional<Eigen::Matrix3d>
      covariance_m2;  ///< of the difference of the two points in m; absent: sigma_p
  int file = 0;       ///< index into PairData::files (one per strip pair)
};

struct PairData {
  std::vector<std::filesystem::path> files;
  std::vector<LidarPair> pairs;
};

/// Reads the pair files that the glob patterns name (relative to `folder`), in sorted order of
/// their names. Columns: t_i, t_j, u_i (3), u_j (3), optionally the upper triangle of the
/// covariance (6). Throws InvalidInput naming file:line; also when no file matches, a vector has
/// zero length, or there is no pair.
PairData ReadPairs(const std::filesystem::path& folder, const std::vector<std::string>& patterns);

/// Text of a pair file with 17 significant digits where needed.
std::string FormatPairs(const std::vector<LidarPair>& pairs);

}  // namespace dn
