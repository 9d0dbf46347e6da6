#pragma once

#include <dn/flight/flight_config.h>

#include <filesystem>
#include <optional>

namespace dn {

/// What a trajectory's smoother wrote about it.
struct AccuracyFiles {
  std::optional<std::filesystem::path> covariance;  ///< for ReadTrajectoryCovariance
  std::optional<std::filesystem::path> series;      ///< for AccuracySeries
  bool named = false;                               ///< by the configuration
};

/// The file that trajectory.sigma_file names, else those that lie beside the trajectory:
/// trajectory_covariance.txt, and trajectory_sigma.txt or POSPac's smrmsg. The section `trajectory`
/// is there. Throws InvalidInput where several smrmsg lie there and none is called after the
/// trajectory.
AccuracyFiles FindAccuracyFiles(const FlightConfig& config);

}  // namespace dn
