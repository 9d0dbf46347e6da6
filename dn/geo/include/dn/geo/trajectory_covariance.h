#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace dn {

/// Joint covariance of the errors of a smoothed trajectory at some epochs of its strips.
struct TrajectoryCovariance {
  std::vector<double> t_s;  ///< increasing
  std::vector<int> strip;   ///< strip of each epoch, from 0, not decreasing
  /// Six rows per epoch: position in the local east, north, up (m), attitude as a rotation vector
  /// about the body axes (rad; q Exp(d)).
  Eigen::MatrixXd covariance;
};

/// Returns the text of trajectory_covariance.txt, with one row for each pair of epochs t_j <= t_i.
/// A row has t_i, strip_i, t_j, strip_j. Then follow the 36 elements of the covariance of pose i
/// with pose j, row by row; m and deg.
std::string FormatTrajectoryCovariance(const TrajectoryCovariance& covariance);

/// Reads a file with the text of FormatTrajectoryCovariance. Throws InvalidInput naming file and
/// line for wrong columns, times, strips or variances, and for a missing row.
TrajectoryCovariance ReadTrajectoryCovariance(const std::filesystem::path& file);

}  // namespace dn
