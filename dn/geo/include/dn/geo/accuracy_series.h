#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace dn {

/// Standard deviations (1 sigma) that a smoother states for its solution at one epoch.
struct EpochAccuracy {
  double t_s = 0.0;
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d::Zero();    ///< position north, east, down
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d::Zero();  ///< roll, pitch, heading
};

/// Standard deviations of a trajectory as a function of time.
class AccuracySeries {
 public:
  /// Reads one of these files:
  ///
  ///   trajectory_sigma.txt   t, sigma east, north, up (m), of three velocities (m/s), of roll,
  ///                          pitch, heading (deg)
  ///   smrmsg                 POSPac's companion of an SBET: little-endian records of ten doubles,
  ///                          time (GPS seconds of week), rms of position north, east, down (m), of
  ///                          three velocities (m/s), of roll, pitch, heading (arc minutes)
  ///
  /// A file named "*.out" is read as smrmsg, any other as trajectory_sigma.txt. Throws InvalidInput
  /// naming file and line, or record, for another format, a sigma that is not positive, and times
  /// that do not increase.
  explicit AccuracySeries(const std::filesystem::path& file);

  /// Returns the standard deviations at t_s, linearly interpolated. Throws InvalidInput outside of
  /// the epochs.
  EpochAccuracy At(double t_s) const;

 private:
  std::filesystem::path file_;
  std::vector<EpochAccuracy> epochs_;
};

}  // namespace dn
