#pragma once

#include <dn/config/yaml_value.h>
#include <dn/files/file_units.h>
#include <dn/files/flight_config.h>
#include <dn/files/yaml_sections.h>

#include "config_names.h"

namespace dn::files_internal {

/// Least standard deviation, m; the same limit holds for every number that must be positive.
inline constexpr double kLeastSigmaM = 1e-12;

/// Largest number of patterns of pair files.
inline constexpr std::size_t kMostPatterns = 10000;

/// Largest number of error processes of a sensor: each adds states to every node of the network.
inline constexpr std::size_t kMostProcesses = 20;

/// Converts between forward-right-down and forward-left-up: a half turn about x.
inline Eigen::Vector3d FlipBody(const Eigen::Vector3d& v) { return {v.x(), -v.y(), -v.z()}; }

/// Converts a rotation to body in the same way. Avoids negative zeros, which would appear in files.
inline void FlipBody(Eigen::Matrix3d* R_b) {
  R_b->bottomRows<2>().array() = 0.0 - R_b->bottomRows<2>().array();
}

/// The functions named Read...Section read the sections of flight.yaml. body_is_flu: body
/// quantities of the file are forward-left-up.
ImuConfig ReadImuSection(const YamlValue& section, bool body_is_flu);
/// Reads the key `columns` of a section; empty if it is absent. Throws InvalidConfig for a name of
/// none of the quantities.
ColumnNames ReadColumnNames(const YamlValue& section, const std::vector<std::string>& quantities);
/// Reads the coordinate system of a text file.
std::string ReadTextCrs(const YamlValue& crs);
/// Reads the key `north`. Returns true for grid north, which requires positions in a grid.
bool ReadNorth(const YamlValue& north, const std::string& crs);

GnssConfig ReadGnssSection(const YamlValue& section, bool body_is_flu);
/// `name` is that of a scanner in a list; it is empty without a list.
LidarConfig ReadLidarSection(const YamlValue& section, bool body_is_flu, const std::string& name);
BeamConfig ReadBeams(const YamlValue& section);
TrajectoryConfig ReadTrajectorySection(const YamlValue& section);
ControlConfig ReadControlSection(const YamlValue& section);
std::vector<TieFiles> ReadTiesSection(const YamlValue& section);
/// Reads the glob patterns of pair files, at least one unless `may_be_empty`.
std::vector<std::string> ReadPairPatterns(const YamlValue& list, bool may_be_empty = false);
std::vector<EstimateEntry> ReadEstimate(const YamlValue& section);
/// Reads the sigmas of an effect: one number for all components, or one for each. `read` is the
/// conversion of a number.
std::vector<double> ReadEffectSigma(const YamlValue& value, const EffectSpec& effect,
                                    double (*read)(const YamlValue&));
/// Returns these sigmas in SI, one for each component.
Eigen::VectorXd EffectSigmaInSi(const EffectSpec& effect, const std::vector<double>& sigma);
UnmodelledConfig ReadUnmodelled(const YamlValue& section);

/// Reads a rotation matrix and makes it orthonormal. Throws InvalidConfig if the matrix is not a
/// rotation.
Eigen::Matrix3d ReadRotation(const YamlValue& value);

/// Reads `time_offset_s` of a sensor section, tag = t + value; 0 if it is absent. Throws
/// InvalidConfig for more than 4e9 s, which exceeds every time since 1970.
double ReadTimeOffset(const YamlValue& section);

/// Keys and units of the bias processes of a sensor triad.
struct ProcessKeys {
  const char* sigma;  ///< key for random_constant and gauss_markov
  ToSi sigma_to_si;
  const char* walk;  ///< key for random_walk
  ToSi walk_to_si;
  const char* white;
  ToSi white_to_si;
};
const ProcessKeys& GyroKeys();
const ProcessKeys& AccelKeys();

}  // namespace dn::files_internal
