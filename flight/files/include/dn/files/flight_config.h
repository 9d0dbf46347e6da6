#pragma once

#include <dn/files/estimate.h>
#include <dn/files/unmodelled.h>
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

/// The robust loss function of a sensor.
enum class RobustKind { kNone, kHuber, kCauchy };

/// Section `imu`.
struct ImuConfig {
  std::string file = "IMU.txt";
  ImuReadOptions read;               ///< includes the body axes and time_span_s of the top level
  std::optional<std::string> grade;  ///< name of the preset in the file
  ImuModel model;                    ///< the preset, overridden by explicit noise values
};

/// Section `gnss`.
struct GnssConfig {
  std::string file = "GPS.txt";
  GnssFormat format = GnssFormat::kOdyn;
  ColumnNames columns;        ///< for kOdyn: see GnssColumns
  bool only_changed = false;  ///< `rows: changed`, see GnssColumns; needs `columns`
  /// Coordinates of the positions for kOdyn and kObGins, see TextCoordinates.
  std::string crs = "geographic";
  bool grid_north = false;     ///< velocities and sigmas refer to the axes of the UTM grid
  double time_offset_s = 0.0;  ///< offset of the time tags, tag = t + value; removed on reading
  /// Position of the antenna in body, FRD.
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d(0.03, 0.03, 0.05);  ///< if the file has no sigmas
  double sigma_scale = 1.0;                    ///< multiplies the sigmas of the file
  std::optional<double> velocity_sigma_scale;  ///< the same for velocities; absent: sigma_scale
  std::optional<bool> use_velocity;            ///< absent: auto, used if the columns exist
  std::vector<GnssProcess> processes;  ///< time-correlated errors of the positions; they add up
  /// `processes: auto`: without stated processes, the effects that the model leaves out contain one
  /// whose size and time constant are estimated.
  bool automatic_process = true;
  RobustKind robust = RobustKind::kNone;
};

/// The selection of pairs from the files; see SelectPairs.
struct PairSelection {
  enum class Strategy { kAll, kMax, kFreq, kTimeWindow };
  Strategy strategy = Strategy::kAll;
  std::optional<long> count;
  std::optional<double> freq_hz;
  std::optional<double> window_s;
  std::uint64_t seed = 0;
};

/// Key `beams` of a scanner: several laser beams that rotate about the scan axis. Each has its own
/// angle to the plane perpendicular to this axis.
struct BeamConfig {
  std::size_t count = 0;
  std::vector<double> angles_rad;  ///< angle of each beam toward +scan_axis; empty: not stated
  /// Standard deviations of the corrections of each beam relative to their means; 0: the beams have
  /// no such errors.
  double angle_sigma_rad = 0.1 * 3.14159265358979323846 / 180.0;
  double range_sigma_m = 0.03;
};

/// Section `lidar`, or one scanner of its list.
struct LidarConfig {
  std::string name;  ///< name of the scanner in a list; empty without a list
  std::vector<std::string> p2p{"LiDAR_p2p.txt"};
  std::vector<std::string> surface_pairs;  ///< glob patterns of the files of surface pairs
  double time_offset_s = 0.0;  ///< offset of the time tags, tag = t + value; removed on reading
  PairSelection pairs;
  Mounting mounting;  ///< in FRD; the boresight is the initial value
  /// Boresight with which the strips were georeferenced (FRD); absent: not declared.
  std::optional<Eigen::Vector3d> georeferenced_with_rad;
  std::optional<Eigen::Vector3d> boresight_sigma_rad;  ///< prior; absent: no prior
  Eigen::Vector3d scan_axis_s = Eigen::Vector3d::UnitX();
  Eigen::Vector3d nadir_axis_s = Eigen::Vector3d::UnitZ();
  std::optional<double> gsd_m;
  double sigma_p_m = 0.0;  ///< as given, or else gsd / 2 / sqrt(3)
  RobustKind robust = RobustKind::kNone;
  std::optional<BeamConfig> beams;  ///< absent: one beam
};

/// Element of `pairs_between`: pairs whose first end one scanner measured, and another the second.
struct PairsBetween {
  std::size_t scanner_i = 0;  ///< indices into the scanners of the flight
  std::size_t scanner_j = 0;
  std::vector<std::string> p2p;  ///< glob patterns
  double sigma_p_m = 0.0;  ///< as given, or else the root mean square of those of the two scanners
};

/// Element of `ties`: pairs with another flight, which measured their other ends.
struct TieFiles {
  static constexpr long kUsualCount = 100;

  std::vector<std::string> p2p;  ///< glob patterns
  bool second = false;           ///< this flight measured the second ends, else the first ones
  long count = kUsualCount;      ///< number of pairs in use, spread over the files
};

/// Section `trajectory`: a given trajectory and its accuracy.
struct TrajectoryConfig {
  std::string file = "trajectory.out";
  std::string sigma_file;     ///< accuracy file; empty: see FindAccuracyFiles
  TrajectoryColumns columns;  ///< as configured; see TextColumns
  double sigma_xy_m = 0.03;
  double sigma_z_m = 0.05;
  double sigma_rp_rad = 0.003 * 3.14159265358979323846 / 180.0;
  double sigma_y_rad = 0.005 * 3.14159265358979323846 / 180.0;
};

/// Section `gh`: the Gauss-Helmert adjustment.
struct GhConfig {
  bool exponential = true;  ///< rotation: exp (true) or small_angle (false)
  bool libor_compat = false;
};

/// A strip with its name and time interval.
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

/// Section `control`: surveyed points and planes (dn/files/control.h).
struct ControlConfig {
  std::vector<std::string> files{"control/*.txt"};  ///< glob patterns
  std::string crs;  ///< coordinates of the files, see TextCoordinates; empty: strips_crs
  std::optional<Eigen::Vector3d> sigma_enu_m;  ///< if a file has no sigmas
  std::optional<double> laser_sigma_m;         ///< noise of a return, see LaserSigma
  /// Prior of a constant shift between the coordinates of the control and those of GNSS; absent:
  /// there is none.
  std::optional<Eigen::Vector3d> datum_shift_sigma_m;
  std::vector<std::string> checks;  ///< names of points that are withheld
  double search_radius_m = 1.0;     ///< of the returns around a point without a laser vector
  double corner_radius_m = 3.0;     ///< the same for a corner
};

/// The content of flight.yaml, checked, with defaults, converted to SI, radian and
/// forward-right-down.
struct FlightConfig {
  std::filesystem::path folder;  ///< folder of the data
  std::filesystem::path file;    ///< file from which this was read, for messages
  std::string name;
  bool body_is_flu = false;
  std::optional<Geodetic> origin;
  std::optional<Eigen::Vector2d> time_span_s;
  std::vector<StripInterval> strips;
  std::string strips_crs = "map";
  bool strips_crs_stated = false;  ///< false: the headers of the strips may name another system
  std::optional<ImuConfig> imu;    ///< absent: flight.yaml has no section imu
  std::optional<GnssConfig> gnss;
  std::optional<LidarConfig> lidar;        ///< the first scanner
  std::vector<LidarConfig> more_scanners;  ///< the others; see dn/files/scanners.h
  std::vector<PairsBetween> pairs_between;
  std::vector<TieFiles> ties;
  std::optional<TrajectoryConfig> trajectory;
  std::optional<ControlConfig> control;  ///< absent: the defaults
  GhConfig gh;
  std::vector<EstimateEntry> estimate{{.unknown = "boresight"}};
  UnmodelledConfig unmodelled;
  NetworkConfig network;
  /// A model deficiency that a diagnosis found and this configuration does not describe; empty if
  /// there is none.
  std::string unexplained;
};

/// Returns whether the GNSS positions have a process whose size and time constant are estimated.
/// They do if gnss.processes is auto, and the model is not the pure one.
bool HasAutomaticGnssProcess(const FlightConfig& config);

/// Returns the columns of a text trajectory as the section `trajectory` describes them, with the
/// body axes and the origin of the flight.
TrajectoryColumns TextColumns(const FlightConfig& config);

/// Reads and checks flight.yaml of a flight folder, or a file of that kind under another name. The
/// data are in the folder of this file, or else in its `data_folder`. Throws InvalidConfig with
/// file:line for a missing file, bad YAML, and an unknown key (with the nearest known one). Also
/// throws for a value of the wrong type, shape or range, and for an unknown preset. An entry of
/// `estimate` must be a fixed effect. A missing section is not an error here; the command that
/// needs it reports it. `changes` are "key.of.keys=value" with a YAML value each, applied before
/// reading. Throws InvalidConfig for a change without "=".
FlightConfig ReadFlightConfig(const std::filesystem::path& folder_or_file,
                              const std::vector<std::string>& changes = {});

/// Reads and checks the text of `folder`/flight.yaml, which need not exist.
FlightConfig ParseFlightConfig(const std::string& text, const std::filesystem::path& folder);

/// Returns the resolved configuration as YAML (config.resolved.yaml). Reading it gives the same
/// configuration. Body quantities are in FRD with `body: FRD`, like all results.
std::string FormatFlightConfig(const FlightConfig& config);

/// Returns the configuration as a file that commands accept in any folder. Body quantities are in
/// the axes of the data files, and `data_folder` is set.
std::string FormatFlightFile(const FlightConfig& config);

/// Returns an element of gnss.processes: "{type: gauss_markov, sigma_enu_m: [0.01, 0.01, 0.02],
/// tau_s: 120}", with `grows_with: bank` if the error grows with the bank.
std::string FormatGnssProcess(const GnssProcess& process);

}  // namespace dn
