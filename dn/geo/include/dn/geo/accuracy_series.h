#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace dn {

/// What a smoother states about its solution at one epoch, 1 sigma.
struct EpochAccuracy {
  double t_s = 0.0;
  Eigen::Vector3d sigma_ned_m = Eigen::Vector3d::Zero();    ///< position north, east, down
  Eigen::Vector3d sigma_rph_rad = Eigen::Vector3d::Zero();  ///< roll, pitch, heading
};

/// The accuracies of a trajectory by time.
class AccuracySeries {
 public:
  /// From one of
  ///
  ///   trajectory_sigma.txt   t, sigma east, north, up (m), of three velocities (m/s), of roll,
  ///                          pitch, heading (deg)
  ///   smrmsg                 POSPac's companion of an SBET: little-endian records of ten doubles,
  ///                          time (GPS seconds of week), rms of position north, east, down (m), of
  ///                          three velocities (m/s), of roll, pitch, heading (arc minutes)
  ///
  /// A file named "*.out" is taken for the second. Throws InvalidInput naming file and line, or
  /// record, for what is no such file, a sigma that is not positive, and times that do not ascend.
  explicit AccuracySeries(const std::filesystem::path& file);

  /// Linear between the epochs. Throws InvalidInput outside of them.
  EpochAccuracy At(double t_s) const;

 private:
  std::filesystem::path file_;
  std::vector<EpochAccuracy> epochs_;
};

}  // namespace dn
