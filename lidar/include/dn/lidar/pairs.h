#pragma once

#include <dn/lidar/vector_origin.h>

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
  long line = 0;      ///< line of that file, from 1; 0: not from a file
};

/// Point pairs of a flight and the files they came from.
struct PairData {
  std::vector<std::filesystem::path> files;
  std::vector<LidarPair> pairs;
  long repeated_pairs_dropped = 0;
  std::vector<VectorOrigin> origins;  ///< of the laser vectors of each file, the least reliable one
};

/// Files that the glob patterns (*, ?, [..]; relative to `folder`) name, sorted, each once. Throws
/// InvalidInput naming a pattern that matches nothing.
std::vector<std::filesystem::path> FindPairFiles(const std::filesystem::path& folder,
                                                 const std::vector<std::string>& patterns);

/// Reads the pair files that the glob patterns name (relative to `folder`), in sorted order of
/// their names. Columns: t_i, t_j, u_i (3), u_j (3), optionally the upper triangle of the
/// covariance (6). A pair with the epochs and vectors of an earlier one, also with i and j
/// exchanged or in another file, is dropped and counted: it is no second measurement. Vectors count
/// as measured unless a comment line of the file says otherwise (FormatOriginLine). Throws
/// InvalidInput naming file:line; also when a pattern matches no file, a time is no second of week,
/// a vector is shorter than 1 mm or longer than 50 km, a covariance is not positive definite, or
/// there is no pair. time_offset_s: known error of the epochs, tag = t + value, removed first.
PairData ReadPairs(const std::filesystem::path& folder, const std::vector<std::string>& patterns,
                   double time_offset_s = 0.0);

/// Mean length of the laser vectors, m; 0 without pairs.
double MeanRange(const std::vector<LidarPair>& pairs);

/// Text of a pair file with 17 significant digits where needed. Either all pairs carry a
/// covariance or none does: a file has one number of columns. The first line states the origin of
/// computed vectors.
std::string FormatPairs(const std::vector<LidarPair>& pairs, const VectorOrigin& origin = {});

}  // namespace dn
