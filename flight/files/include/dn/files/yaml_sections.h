#pragma once

#include <dn/config/yaml_value.h>
#include <dn/files/flight_config.h>
#include <dn/gnss/gnss_process.h>
#include <dn/imu/imu_model.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

// Readers and writers for parts of flight.yaml that scenarios also have.

/// Reads the noise of an inertial unit from the sections `gyro` and `accel` (white noise,
/// processes). They override the preset named by `preset_key`, if there is one. Throws
/// InvalidConfig if neither gives the white noise.
ImuModel ReadImuNoise(const YamlValue& section, const std::string& preset_key);

/// Returns white noise and processes of a triad in the form that ReadImuNoise reads under `gyro`
/// and `accel`: "{white_deg_sqrt_h: 0.1, processes: [{type: random_constant, sigma_deg_h: 10}]}".
std::string FormatGyroNoise(const SensorNoise& noise);
std::string FormatAccelNoise(const SensorNoise& noise);

/// Reads a list of strips: [{name, t0, t1}, ...]; empty if it is absent. Throws InvalidConfig for a
/// strip that ends before it begins, and for a name given twice.
std::vector<StripInterval> ReadStrips(const YamlValue& list);

/// Returns "{name: "1", t0: 100, t1: 160}".
std::string FormatStrip(const StripInterval& strip);

/// Throws InvalidConfig at `value` unless the name consists of letters, digits and '-', so that it
/// can be a part of file names.
void ExpectPlainName(const YamlValue& value, const std::string& name);

/// Most scanners of a list.
inline constexpr std::size_t kMostScanners = 16;

/// Reads the name of the next scanner of a list; without one it is its number from 1. Throws
/// InvalidConfig for a name that ExpectPlainName refuses, and for one that is among `before`.
std::string ReadScannerName(const YamlValue& item, const std::vector<std::string>& before);

/// Returns a double-quoted YAML scalar.
std::string QuoteYaml(const std::string& text);

/// Reads the list `processes` of a GNSS section; empty if it is absent. Throws InvalidConfig for a
/// type other than gauss_markov, and a grows_with other than none and bank. Also throws for a sigma
/// below 0, sigmas that are all 0, and a tau_s that is not positive.
std::vector<GnssProcess> ReadGnssProcesses(const YamlValue& section);

/// The mounting of a scanner and its scan axes.
struct ScannerAxes {
  Eigen::Matrix3d R_bs_nominal =
      Eigen::Matrix3d::Identity();  ///< `R_sensor_to_body` for a body in FRD
  Eigen::Vector3d scan_axis_s = Eigen::Vector3d::UnitX();
  Eigen::Vector3d nadir_axis_s = Eigen::Vector3d::UnitZ();
};

/// Reads `R_sensor_to_body`, `scan_axis` and `nadir_axis` of a section. body_is_flu: the body axes
/// of the section are forward-left-up. Throws InvalidConfig for a matrix that is not a rotation,
/// and for a nadir axis above the horizon. Also throws for axes that are not unit vectors (to 1e-3)
/// or not perpendicular (to half a degree).
ScannerAxes ReadScannerAxes(const YamlValue& section, bool body_is_flu);

/// Reads the angles of the beams of a scanner in deg; returns rad. Throws InvalidConfig for fewer
/// than two beams or more than kMostBeams, and for an angle outside -90 to 90 deg.
std::vector<double> ReadBeamAngles(const YamlValue& angles_deg);

/// Reads `angle_sigma_deg` and `range_offset_sigma_m` of a section `beams`. An absent key leaves
/// its value unchanged. Throws InvalidConfig for a negative sigma, and above 5 deg or 1 m.
void ReadBeamSigmas(const YamlValue& section, double* angle_rad, double* range_m);

}  // namespace dn
