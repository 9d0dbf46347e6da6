#pragma once

#include <dn/eigen_alignment.h>
#include <dn/lidar/beam.h>
#include <dn/lidar/vector_origin.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Point-to-point correspondence: one ground point measured at two epochs.
struct LidarPair {
  double t_i_s = 0.0;
  double t_j_s = 0.0;
  Eigen::Vector3d u_i_s = Eigen::Vector3d::Zero();  ///< laser vector at t_i in the sensor frame, m
  Eigen::Vector3d u_j_s = Eigen::Vector3d::Zero();
  /// Covariance of the difference of the two points in m; absent: sigma_p applies.
  std::optional<Eigen::Matrix3d> covariance_m2;
  int file = 0;   ///< index into PairData::files (one file per strip pair)
  long line = 0;  ///< line of that file, from 1; 0: the pair does not come from a file
  /// Scanners that measured the two ends; indices into the scanners of the flight.
  int scanner_i = 0;
  int scanner_j = 0;
  /// Beams that measured the two ends, of a scanner with several beams; kNoBeam: unknown, or
  /// several.
  int beam_i = kNoBeam;
  int beam_j = kNoBeam;

  bool has_beams() const { return beam_i != kNoBeam || beam_j != kNoBeam; }
};

/// Point pairs of a flight and the files that contain them.
struct PairData {
  std::vector<std::filesystem::path> files;
  std::vector<LidarPair> pairs;
  long repeated_pairs_dropped = 0;
  /// Origin of the laser vectors of each file: the least reliable one in the file.
  std::vector<VectorOrigin> origins = {};
};

/// Returns the files that match the glob patterns (*, ?, [..]; relative to `folder`), sorted and
/// without duplicates. Throws InvalidInput with the pattern if a pattern matches no file.
std::vector<std::filesystem::path> FindPairFiles(const std::filesystem::path& folder,
                                                 const std::vector<std::string>& patterns);

/// Reads the pair files that match the glob patterns (relative to `folder`), sorted by name. The
/// columns are t_i, t_j, u_i (3) and u_j (3). The upper triangle of the covariance (6) and the
/// beams of the two ends (2) are optional. The number of columns tells which of them there are.
/// Vectors count as measured unless a comment line of the file states otherwise (FormatOriginLine).
///
/// A pair with the epochs and vectors of an earlier pair is not a second measurement: it is dropped
/// and counted. This also applies if i and j are exchanged or the pair is in another file.
///
/// time_offset_s: known error of the epochs (tag = t + time_offset_s), subtracted first.
///
/// Throws InvalidInput with file:line if a time is not a second of week, or a covariance is not
/// positive definite. Also throws if a beam is not an integer from -1 (several beams) to 1023. Also
/// throws if a vector is shorter than 1 mm or longer than 50 km. The same holds if a pattern
/// matches no file, and without pairs.
PairData ReadPairs(const std::filesystem::path& folder, const std::vector<std::string>& patterns,
                   double time_offset_s = 0.0);

/// Returns the mean length of the laser vectors, m; 0 without pairs.
double MeanRange(const std::vector<LidarPair>& pairs);

/// Returns the text of a pair file, with up to 17 significant digits. Since a file has a fixed
/// number of columns, either all pairs or none must have a covariance. The columns of the beams are
/// written if a pair has a beam. The first line states the origin of computed vectors.
std::string FormatPairs(const std::vector<LidarPair>& pairs, const VectorOrigin& origin = {});

}  // namespace dn
