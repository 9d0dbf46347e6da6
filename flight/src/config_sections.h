#pragma once

#include <dn/config/yaml_value.h>
#include <dn/flight/file_units.h>
#include <dn/flight/flight_config.h>
#include <dn/flight/yaml_sections.h>

#include "config_names.h"

namespace dn::internal {

/// The least standard deviation [m], as of every number that must be positive.
inline constexpr double kLeastSigmaM = 1e-12;

/// The most error processes of a sensor: each adds states to every node of the network.
inline constexpr std::size_t kMostProcesses = 20;

/// Forward-right-down from forward-left-up, and back: a half turn about x.
inline Eigen::Vector3d FlipBody(const Eigen::Vector3d& v) { return {v.x(), -v.y(), -v.z()}; }

/// The same of a rotation to body. Without negative zeros, which would be written.
inline void FlipBody(Eigen::Matrix3d* R_b) {
  R_b->bottomRows<2>().array() = 0.0 - R_b->bottomRows<2>().array();
}

/// Sections of flight.yaml. body_is_flu: body quantities of the file are forward-left-up.
ImuConfig ReadImuSection(const YamlValue& section, bool body_is_flu);
/// A coordinate system of a text file.
std::string ReadTextCrs(const YamlValue& crs);
/// True: the north of a grid, which the positions must be in.
bool ReadNorth(const YamlValue& north, const std::string& crs);

GnssConfig ReadGnssSection(const YamlValue& section, bool body_is_flu);
LidarConfig ReadLidarSection(const YamlValue& section, bool body_is_flu);
TrajectoryConfig ReadTrajectorySection(const YamlValue& section);
std::vector<EstimateEntry> ReadEstimate(const YamlValue& section);

/// A rotation matrix, made exact. Throws InvalidConfig for what is none.
Eigen::Matrix3d ReadRotation(const YamlValue& value);

/// `time_offset_s` of a sensor's section, tag = t + value; 0 where it is absent. Throws InvalidConfig
/// for more than 4e9 s, which no time since 1970 has.
double ReadTimeOffset(const YamlValue& section);

/// How the bias processes of one sensor triad are spelt.
struct ProcessKeys {
  const char* sigma;  ///< random_constant, gauss_markov
  ToSi sigma_to_si;
  const char* walk;  ///< random_walk
  ToSi walk_to_si;
  const char* white;
  ToSi white_to_si;
};
const ProcessKeys& GyroKeys();
const ProcessKeys& AccelKeys();

}  // namespace dn::internal
