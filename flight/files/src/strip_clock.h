#pragma once

#include <dn/error.h>
#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>

namespace dn::files_internal {

/// Compares the points of a strip with the trajectory to find a wrong clock. With laser vectors,
/// the points of the file must lie near those of the trajectory. Without, they must lie below it on
/// average, since scanners look less than 30 deg forward.
class StripClock {
 public:
  static constexpr std::size_t kPointsPerSample = 100;  ///< of so many points one suffices

  explicit StripClock(bool has_vectors) : has_vectors_(has_vectors) {}

  /// Takes a point of the file, the same point by the trajectory, and its pose.
  void Take(const MapPose& pose, const Eigen::Vector3d& in_file_m,
            const Eigen::Vector3d& by_trajectory_m);

  /// Throws InvalidInput if the points lie along the course before or behind the trajectory by
  /// more than a boresight or a scanner explains. declared_s: the offset that was removed from the
  /// time tags.
  void ExpectAgreement(double declared_s, const FileLocation& where) const;

 private:
  /// Returns the offset of the time tags, s (tag = t + offset). There is one if the points lie
  /// along the course before or behind the trajectory by more than a boresight or a scanner
  /// explains.
  std::optional<double> Offset() const;

  bool has_vectors_;
  double count_ = 0.0, along_m_ = 0.0, along2_m2_ = 0.0, speed_mps_ = 0.0, range_m_ = 0.0,
         apart2_m2_ = 0.0;
};

}  // namespace dn::files_internal
