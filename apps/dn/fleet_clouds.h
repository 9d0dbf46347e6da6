#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "command.h"

namespace dn::apps {

/// A flight of several, whose strips get new coordinates.
struct FleetClouds {
  std::string name;
  std::string flight;            ///< flight folder or YAML file
  std::filesystem::path folder;  ///< result of the flight: its adjusted trajectory, its beams
  Eigen::Vector3d boresight_rad;
};

/// Georeferences the strips of each flight into `folder`/clouds, in its own process. `changes`:
/// --set values for all flights. Throws FailedWithResults if a flight fails, with its message.
void GeoreferenceFlights(const std::vector<FleetClouds>& flights,
                         const std::vector<std::string>& changes, int at_once, Run* run);

}  // namespace dn::apps
