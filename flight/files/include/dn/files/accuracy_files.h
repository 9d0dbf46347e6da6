#pragma once

#include <dn/files/flight_config.h>

#include <filesystem>
#include <optional>

namespace dn {

/// The accuracy files that belong to a trajectory.
struct AccuracyFiles {
  std::optional<std::filesystem::path> covariance;  ///< file for ReadTrajectoryCovariance
  std::optional<std::filesystem::path> series;      ///< file for AccuracySeries
  bool named = false;                               ///< named by trajectory.sigma_file
};

/// Returns the file named by trajectory.sigma_file, or else the files in the folder of the
/// trajectory: trajectory_covariance.txt, and trajectory_sigma.txt or the smrmsg file of POSPac.
/// The configuration must have the section `trajectory`. Throws InvalidInput if the folder has
/// several smrmsg files and none has the name of the trajectory.
AccuracyFiles FindAccuracyFiles(const FlightConfig& config);

}  // namespace dn
