#pragma once

#include <dn/config/yaml_value.h>
#include <dn/flight/flight_config.h>
#include <dn/gnss/gnss_process.h>
#include <dn/imu/imu_model.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

// Parts of flight.yaml that scenarios have, too.

/// Noise of an inertial unit from the sections `gyro` and `accel` (white noise, processes) over the
/// preset that `preset_key` names, if any. Throws InvalidConfig where neither gives the white
/// noise.
ImuModel ReadImuNoise(const YamlValue& section, const std::string& preset_key);

/// White noise and processes of a triad as ReadImuNoise reads them under `gyro` and `accel`:
/// "{white_deg_sqrt_h: 0.1, processes: [{type: random_constant, sigma_deg_h: 10}]}".
std::string FormatGyroNoise(const SensorNoise& noise);
std::string FormatAccelNoise(const SensorNoise& noise);

/// A list of strips: [{name, t0, t1}, ...]; none where it is absent. Throws InvalidConfig for one
/// that ends before it begins, and a name given twice.
std::vector<StripInterval> ReadStrips(const YamlValue& list);

/// "{name: "1", t0: 100, t1: 160}".
std::string FormatStrip(const StripInterval& strip);

/// A double-quoted YAML scalar.
std::string QuoteYaml(const std::string& text);

/// The list `processes` of a section on GNSS; nothing where it is absent. Throws InvalidConfig for
/// another type than gauss_markov, a sigma below 0, sigmas that are all 0, and a tau_s that is not
/// positive.
std::vector<GnssProcess> ReadGnssProcesses(const YamlValue& section);

/// How a scanner is mounted and how it turns.
struct ScannerAxes {
  Eigen::Matrix3d R_bs = Eigen::Matrix3d::Identity();  ///< `R_sensor_to_body`; body is FRD
  Eigen::Vector3d scan_axis_s = Eigen::Vector3d::UnitX();
  Eigen::Vector3d nadir_axis_s = Eigen::Vector3d::UnitZ();
};

/// `R_sensor_to_body`, `scan_axis` and `nadir_axis` of a section. body_is_flu: its body is
/// forward-left-up. Throws InvalidConfig for what is no rotation, axes that are no unit vectors (to
/// 1e-3) or not perpendicular (to half a degree), and a nadir axis above the horizon.
ScannerAxes ReadScannerAxes(const YamlValue& section, bool body_is_flu);

}  // namespace dn
