#pragma once

#include <dn/flight/estimate.h>
#include <dn/geo/local_frame.h>
#include <dn/gnss/gnss_data.h>
#include <dn/gnss/gnss_process.h>
#include <dn/imu/imu_data.h>
#include <dn/imu/imu_model.h>
#include <dn/lidar/mounting.h>

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// The robust loss of a sensor.
enum class RobustKind { kNone, kHuber, kCauchy };

/// Section `imu`.
struct ImuConfig {
  std::string file = "IMU.txt";
  ImuReadOptions read;               ///< the axes and the span with those of the top level
  std::optional<std::string> grade;  ///< preset named in the file
  ImuModel model;                    ///< resolved: preset overridden by explicit noise
};

/// Section `gnss`.
struct GnssConfig {
  std::string file = "GPS.txt";
  GnssFormat format = GnssFormat::kOdyn;
  std::string crs = "geographic";  ///< of the positions of kOdyn and kObGins, as TextCoordinates
  bool grid_north = false;         ///< velocities and sigmas are along the UTM grid
  double time_offset_s = 0.0;      ///< of the file's tags, tag = t + value; removed on reading
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();          ///< antenna in body, FRD
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d(0.03, 0.03, 0.05);  ///< where the file has none
  double sigma_scale = 1.0;
  std::optional<bool> use_velocity;    ///< absent: auto, when the columns are there
  std::vector<GnssProcess> processes;  ///< errors of the positions that last, their sum
  RobustKind robust = RobustKind::kNone;
};

/// Which pairs of the files are used; see SelectPairs.
struct PairSelection {
  enum class Strategy { kAll, kMax, kFreq, kTimeWindow };
  Strategy strategy = Strategy::kAll;
  std::optional<long> count;
  std::optional<double> freq_hz;
  std::optional<double> window_s;
  std::uint64_t seed = 0;
};

/// Section `lidar`.
struct LidarConfig {
  std::vector<std::string> p2p{"LiDAR_p2p.txt"};
  double time_offset_s = 0.0;  ///< of the pairs' epochs, tag = t + value; removed on reading
  PairSelection pairs;
  Mounting mounting;  ///< FRD; boresight: initial value
  /// Boresight that the strips were georeferenced with (FRD); absent: not declared.
  std::optional<Eigen::Vector3d> georeferenced_with_rad;
  std::optional<Eigen::Vector3d> boresight_sigma_rad;  ///< prior; absent: free
  Eigen::Vector3d scan_axis_s = Eigen::Vector3d::UnitX();
  Eigen::Vector3d nadir_axis_s = Eigen::Vector3d::UnitZ();
  std::optional<double> gsd_m;
  double sigma_p_m = 0.0;  ///< resolved: given, or gsd / 2 / sqrt(3)
  RobustKind robust = RobustKind::kNone;
};

/// Section `trajectory`: a given trajectory and what is known of its accuracy.
struct TrajectoryConfig {
  std::string file = "trajectory.out";
  std::string sigma_file;     ///< of its accuracy; empty: what lies beside the trajectory
  TrajectoryColumns columns;  ///< as declared; see TextColumns
  double sigma_xy_m = 0.03;
  double sigma_z_m = 0.05;
  double sigma_rp_rad = 0.003 * 3.14159265358979323846 / 180.0;
  double sigma_y_rad = 0.005 * 3.14159265358979323846 / 180.0;
};

/// Section `gh`: the Gauss-Helmert adjustment.
struct GhConfig {
  bool exponential = true;  ///< rotation: exp | small_angle
  bool libor_compat = false;
};

/// A strip by name and time.
struct StripInterval {
  std::string name;
  double t0_s = 0.0;
  double t1_s = 0.0;
};

/// Section `network`.
struct NetworkConfig {
  enum class Inertial { kPreintegrated, kRaw };
  Inertial inertial = Inertial::kPreintegrated;
  std::optional<double> node_rate_hz;  ///< absent: auto
};

/// flight.yaml, checked, converted to SI, radian and forward-right-down, with defaults filled in.
struct FlightConfig {
  std::filesystem::path folder;  ///< of the data
  std::filesystem::path file;    ///< that this was read from, for messages
  std::string name;
  bool body_is_flu = false;
  std::optional<Geodetic> origin;
  std::optional<Eigen::Vector2d> time_span_s;
  std::vector<StripInterval> strips;
  std::string strips_crs = "map";
  std::optional<ImuConfig> imu;  ///< absent: no imu section
  std::optional<GnssConfig> gnss;
  std::optional<LidarConfig> lidar;
  std::optional<TrajectoryConfig> trajectory;
  GhConfig gh;
  std::vector<EstimateEntry> estimate{{.unknown = "boresight"}};
  NetworkConfig network;
  /// What a diagnosis found in the data that this configuration does not model; empty: nothing.
  std::string unexplained;
};

/// The columns of a text trajectory of the flight, as `trajectory` declares them, with the body and
/// the origin of the flight.
TrajectoryColumns TextColumns(const FlightConfig& config);

/// Reads and checks flight.yaml of a flight folder, or a file of that kind under another name. The
/// data lie beside it, else in its `data_folder`. Throws InvalidConfig with file:line for a missing
/// file, bad YAML, an unknown key (naming the nearest known one), a value of the wrong type, shape
/// or range, an unknown preset, what is no fixed effect under `estimate`. A missing section is not
/// an error here: the command that needs it says so.
/// `changes` are "key.of.keys=value" with a YAML value each, made before it is read. Throws
/// InvalidConfig for one without "=".
FlightConfig ReadFlightConfig(const std::filesystem::path& folder_or_file,
                              const std::vector<std::string>& changes = {});

/// The same for a text: that of `folder`/flight.yaml, which need not exist.
FlightConfig ParseFlightConfig(const std::string& text, const std::filesystem::path& folder);

/// The resolved configuration as YAML (config.resolved.yaml): reading it
/// back gives the same configuration. Body quantities are written in FRD with `body: FRD`, as all
/// results are.
std::string FormatFlightConfig(const FlightConfig& config);

/// The same as a file that commands run on wherever it lies: body quantities in the axes of the
/// data files, and the folder of these.
std::string FormatFlightFile(const FlightConfig& config);

/// An element of gnss.processes: "{type: gauss_markov, sigma_enu_m: [0.01, 0.01, 0.02], tau_s: 120}".
std::string FormatGnssProcess(const GnssProcess& process);

}  // namespace dn
