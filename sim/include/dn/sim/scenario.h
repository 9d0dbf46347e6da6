#pragma once

#include <dn/error.h>
#include <dn/files/effect_times.h>
#include <dn/files/flight_config.h>
#include <dn/geo/local_frame.h>
#include <dn/gnss/gnss_process.h>
#include <dn/imu/imu_data.h>
#include <dn/imu/imu_model.h>
#include <dn/lidar/mounting.h>
#include <dn/sim/vibration.h>

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Flight line: straight and level from start to end, in the mapping frame.
struct PlannedLine {
  Eigen::Vector2d start_en_m = Eigen::Vector2d::Zero();  ///< east, north
  Eigen::Vector2d end_en_m = Eigen::Vector2d::Zero();
  double height_m = 0.0;  ///< up, above the origin of m
  double speed_mps = 0.0;
};

/// Shape of the spectra of turbulence.
enum class TurbulenceSpectrum {
  kSmooth,  ///< waves of up to 1 Hz
  kDryden   ///< Dryden's gusts, up to the inertial rate (DrydenGusts)
};

/// Root mean squares of the motion that turbulence adds to the planned one.
struct TurbulenceScenario {
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  double heading_rad = 0.0;
  double speed_mps = 0.0;
  double height_m = 0.0;
  TurbulenceSpectrum spectrum = TurbulenceSpectrum::kSmooth;
  double wingspan_m = 10.0;  ///< only for kDryden
};

/// Path to fly, and motion of the aircraft along it.
struct PlanScenario {
  double warm_up_s = 0.0;  ///< time for turns and lines before the first strip
  std::vector<PlannedLine> lines;
  double bank_rad = 0.0;  ///< maximum bank angle in turns
  TurbulenceScenario turbulence;
  VibrationScenario vibration;
  double crab_rad = 0.0;          ///< heading minus course
  bool stabilised_mount = false;  ///< the mount keeps the body level within 0.3 deg
  /// File of a trajectory to fly instead of `lines`, with its own times and attitude.
  std::optional<std::filesystem::path> replay;
  /// Times of a replay at which the scanner measures; empty: the straight parts of the trajectory.
  std::vector<StripInterval> strips;
  FileLocation where;  ///< location of the lines in the scenario
};

/// Kinds of landscape that a scenario can select.
enum class TerrainKind {
  kBuiltUp,
  kMixed,
  kNatural,
  kMountain,
  kFlat,
  // The detailed kinds, which have plants that let light through, cars and man-made ground.
  kForest,
  kOrchard,
  kTown,
  kQuarry,
  kFields
};

/// Returns true for the detailed kinds.
inline bool IsDetailed(TerrainKind kind) { return kind >= TerrainKind::kForest; }

/// Shape of the ground, and objects on it.
struct TerrainScenario {
  TerrainKind kind = TerrainKind::kMixed;
  double relief_m = 0.0;      ///< the ground stays within base_m +- relief_m / 2
  double wavelength_m = 0.0;  ///< wavelength of the longest undulation
  double base_m = 0.0;        ///< mean height of the ground above the origin of m
  double buildings_per_km2 = 0.0;
  double trees_per_km2 = 0.0;
  double roughness_m = 0.0;    ///< rms of the relief of a few metres and less (Roughness)
  double water_share = 0.0;    ///< fraction of the ground that is water: the lowest part of it
  double woods_share = 0.0;    ///< fraction of mixed, natural or mountain ground with forest
  double cars_per_km2 = 0.0;   ///< in a town
  double conifer_share = 0.5;  ///< fraction of the trees of a forest that are conifers
  bool leaves = true;          ///< false: deciduous plants of a detailed terrain are bare
  std::uint64_t seed = 1;
};

/// Returns whether rays meet plants that let light through, or cars.
inline bool HasScene(const TerrainScenario& terrain) {
  return IsDetailed(terrain.kind) || terrain.woods_share > 0.0;
}

/// Inertial sensor.
struct ImuScenario {
  double rate_hz = 200.0;
  std::optional<std::string> preset;  ///< absent if explicit noise overrides the preset
  ImuModel model;
  ImuSampling sampling = ImuSampling::kMean;
  /// Cut-off frequency of an anti-aliasing filter before the sampling, Hz; absent: no filter.
  std::optional<double> filter_hz;
};

/// GNSS receiver.
struct GnssScenario {
  double rate_hz = 1.0;
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d(0.03, 0.03, 0.05);
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();  ///< assumed value
  bool velocity = false;
  std::vector<GnssProcess> processes;  ///< both assumed and simulated
};

/// Arrangement of the laser beams of a scanner.
enum class ScanPattern {
  kLine,     ///< the beams lie in the plane perpendicular to the scan axis, and sweep to one side
  kZigzag,   ///< the same plane, but the mirror swings to and fro and slows down at the sides
  kCone,     ///< the beams lie on the cone of half angle fov/2 about the nadir axis
  kRotating  ///< several beams rotate about the scan axis, each on a cone about this axis
};

/// Beams of a rotating scanner. Each list has one element per beam.
struct BeamScenario {
  std::vector<double> angles_rad;  ///< assumed angle toward +scan_axis from the plane across it
  double rotation_hz = 10.0;       ///< only for point clouds
  /// Standard deviations of the errors, which the assumed model states.
  double angle_sigma_rad = 0.0;
  double range_sigma_m = 0.0;
  /// Errors; empty: drawn with these standard deviations, with a mean of zero.
  std::vector<double> angle_error_rad;  ///< true angle minus assumed angle
  std::vector<double> range_error_m;    ///< measured range minus true range

  int count() const { return static_cast<int>(angles_rad.size()); }
};

/// Laser scanner and its mounting.
struct LidarScenario {
  std::string name;   ///< name in a list of scanners; empty without a list
  Mounting mounting;  ///< the lever arm is the assumed one, the boresight the true one
  Eigen::Vector3d scan_axis_s = Eigen::Vector3d::UnitX();
  Eigen::Vector3d nadir_axis_s = Eigen::Vector3d::UnitZ();
  double fov_rad = 0.0;  ///< full angle
  ScanPattern pattern = ScanPattern::kLine;
  double gsd_m = 0.0;
  double pulse_rate_hz = 0.0;        ///< from here on: only for point clouds
  double beam_divergence_rad = 0.0;  ///< full angle at which the intensity has fallen to 1/e^2
  double sigma_range_m = 0.0;
  int max_returns = 1;  ///< returns per pulse; 1: only the first, and no intensities or classes
  /// Distance behind a return within which the scanner cannot separate another one.
  double range_resolution_m = 2.5;
  double noise_share = 0.0;     ///< fraction of the pulses that give a false return
  double scan_variation = 0.0;  ///< rms of the relative difference of scan rates between strips
  BeamScenario beams;           ///< only for kRotating
};

/// Number and accuracy of the point pairs.
struct PairScenario {
  long count = 0;
  /// Per coordinate of the difference of a pair of the first scanner; those of the others are in
  /// proportion to their gsd_m.
  double sigma_p_m = 0.0;
  long between = 0;  ///< number of pairs between each two scanners; `count` is that of each scanner
  /// Fraction of the variance that neighbouring pairs of two strips share, and the distance at
  /// which their correlation has fallen to exp(-1/2). The shared error is in the sensor frame of
  /// the first strip.
  double shared_fraction = 0.0;
  double shared_length_m = 0.0;
  FileLocation where;  ///< location of the section in the scenario
};

/// Number and accuracy of the surveyed points.
struct ControlScenario {
  long points = 0;  ///< observations
  long checks = 0;  ///< points that the assumed model withholds
  /// Peaks of gables that are observations or checks. They have no laser vector: the estimator
  /// finds them in the point clouds.
  long corners = 0, corner_checks = 0;
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d(0.01, 0.01, 0.015);

  long size() const { return points + checks + corners + corner_checks; }
  bool empty() const { return size() == 0; }
};

/// Entry of `effects:`: an error that the data contain and the assumed model lacks.
struct Effect {
  std::string name;           ///< name in EffectTable
  std::vector<double> value;  ///< in the units of EffectTable
  EffectTimes times;
  FileLocation where;        ///< location of the entry in the scenario
  std::string scanner = {};  ///< scanner that has it; empty: every scanner
};

/// Complete input of `dn simulate`: plan, terrain and sensors. Units are SI and radian; the body is
/// forward-right-down.
struct Scenario {
  std::string name;
  Geodetic origin;
  double start_s = 0.0;  ///< beginning of the first inertial interval, GPS seconds of week
  PlanScenario plan;
  TerrainScenario terrain;
  ImuScenario imu;
  GnssScenario gnss;
  LidarScenario lidar;  ///< the first scanner
  std::vector<LidarScenario> more_scanners;
  PairScenario pairs;
  ControlScenario control;
  bool strips = false;  ///< true: point clouds are simulated in addition
  std::vector<Effect> effects;
};

/// Returns one scenario per scanner, with this scanner and its effects alone.
std::vector<Scenario> ScannerScenarios(const Scenario& scenario);

/// Throws InvalidConfig if the scenario has several scanners; `command` is for the message.
void ExpectOneScanner(const Scenario& scenario, const std::string& command);

/// Returns the names of the scenarios that come with the program.
std::vector<std::string> ScenarioNames();

/// Reads a shipped scenario by name, or else a scenario file. `changes` are entries
/// "key.of.keys=value" with YAML values; they are applied before reading. Throws InvalidConfig if
/// neither exists (with the nearest shipped name), and as ParseScenario does.
Scenario ReadScenario(const std::string& name_or_path,
                      const std::vector<std::string>& changes = {});

/// Returns the YAML text of a shipped scenario by name, or else of a scenario file. Throws
/// InvalidConfig as ReadScenario does.
std::string ScenarioText(const std::string& name_or_path);

/// Reads a scenario from YAML. `where` is the file that messages name; a relative `replay` refers
/// to the folder of this file. Throws InvalidConfig with file:line:column for invalid YAML and for
/// a value of the wrong type, shape or range. For an unknown key, effect, preset or terrain kind,
/// the message contains the nearest known one.
Scenario ParseScenario(const std::string& yaml_text, const std::string& where);

/// Formats the scenario as YAML. ParseScenario reads the same scenario from it. A relative path of
/// a replay remains valid only in the same folder.
std::string FormatScenario(const Scenario& scenario);

}  // namespace dn
