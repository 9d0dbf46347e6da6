#pragma once

#include <dn/error.h>
#include <dn/flight/effect_times.h>
#include <dn/flight/flight_config.h>
#include <dn/geo/local_frame.h>
#include <dn/gnss/gnss_process.h>
#include <dn/imu/imu_model.h>
#include <dn/lidar/mounting.h>

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// A flight line: straight and level from start to end, in the mapping frame.
struct PlannedLine {
  Eigen::Vector2d start_en_m = Eigen::Vector2d::Zero();  ///< east, north
  Eigen::Vector2d end_en_m = Eigen::Vector2d::Zero();
  double height_m = 0.0;  ///< up, above the origin of m
  double speed_mps = 0.0;
};

/// Root mean squares of the motion that the air adds to the planned one.
struct TurbulenceScenario {
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
  double heading_rad = 0.0;
  double speed_mps = 0.0;
  double height_m = 0.0;
};

/// The path to fly and how the aircraft moves on it.
struct PlanScenario {
  double warm_up_s = 0.0;  ///< turns and lines before the first strip
  std::vector<PlannedLine> lines;
  double bank_rad = 0.0;  ///< largest bank in turns
  TurbulenceScenario turbulence;
  double crab_rad = 0.0;          ///< heading minus course
  bool stabilised_mount = false;  ///< the body is held level within 0.3 deg
  /// Trajectory to fly instead of `lines`, at its own times and with its own attitude.
  std::optional<std::filesystem::path> replay;
  /// Of a replay, when the scanner sees the ground; empty: on its straight stretches.
  std::vector<StripInterval> strips;
  FileLocation where;  ///< of the lines in the scenario
};

/// Landscapes that a scenario can name.
enum class TerrainKind { kBuiltUp, kMixed, kNatural, kMountain, kFlat };

/// The ground: its shape, and what stands on it.
struct TerrainScenario {
  TerrainKind kind = TerrainKind::kMixed;
  double relief_m = 0.0;      ///< the ground stays within base_m +- relief_m / 2
  double wavelength_m = 0.0;  ///< of the longest undulation
  double base_m = 0.0;        ///< mean height of the ground above the origin of m
  double buildings_per_km2 = 0.0;
  double trees_per_km2 = 0.0;
  double roughness_m = 0.0;  ///< rms of the relief of a few metres and less (Roughness)
  double water_share = 0.0;  ///< of the ground: below some height it is water
  std::uint64_t seed = 1;
};

/// The inertial sensor.
struct ImuScenario {
  double rate_hz = 200.0;
  std::optional<std::string> preset;  ///< kept only where no explicit noise overrides it
  ImuModel model;
};

/// The GNSS receiver.
struct GnssScenario {
  double rate_hz = 1.0;
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d(0.03, 0.03, 0.05);
  Eigen::Vector3d lever_arm_b_m = Eigen::Vector3d::Zero();  ///< assumed
  bool velocity = false;
  std::vector<GnssProcess> processes;  ///< assumed, and simulated
};

/// How the beams of a scanner are spread.
enum class ScanPattern {
  kLine,  ///< the beams lie in the plane that is perpendicular to the scan axis
  kCone   ///< the beams lie on the cone of half angle fov/2 about the nadir axis
};

/// The laser scanner and its mounting.
struct LidarScenario {
  Mounting mounting;  ///< lever arm: assumed; boresight: the true one
  Eigen::Vector3d scan_axis_s = Eigen::Vector3d::UnitX();
  Eigen::Vector3d nadir_axis_s = Eigen::Vector3d::UnitZ();
  double fov_rad = 0.0;  ///< full angle
  ScanPattern pattern = ScanPattern::kLine;
  double gsd_m = 0.0;
  double pulse_rate_hz = 0.0;        ///< this and what follows: of point clouds alone
  double beam_divergence_rad = 0.0;  ///< full angle where the intensity has fallen by e^2
  double sigma_range_m = 0.0;
};

/// The point pairs: how many, and how good.
struct PairScenario {
  long count = 0;
  double sigma_p_m = 0.0;  ///< per coordinate of the pair's difference
  FileLocation where;      ///< of the section in the scenario
};

/// An entry of `effects:`: something that the data contain and the assumed model lacks.
struct Effect {
  std::string name;           ///< of EffectTable
  std::vector<double> value;  ///< in the units of the table
  EffectTimes times;
  FileLocation where;  ///< of the entry in the scenario
};

/// Everything that `dn simulate` needs: the plan, the world and the sensors. SI, radian, body
/// forward-right-down.
struct Scenario {
  std::string name;
  Geodetic origin;
  double start_s = 0.0;  ///< GPS seconds of week of the first inertial interval's begin
  PlanScenario plan;
  TerrainScenario terrain;
  ImuScenario imu;
  GnssScenario gnss;
  LidarScenario lidar;
  PairScenario pairs;
  bool strips = false;  ///< point clouds are simulated, too
  std::vector<Effect> effects;
};

/// Names of the scenarios that come with the program.
std::vector<std::string> ScenarioNames();

/// A shipped scenario by name, else a scenario file. Throws InvalidConfig when there is neither
/// (naming the nearest shipped one), and as ParseScenario does. `changes` are "key.of.keys=value"
/// with a YAML value each, made before it is read.
Scenario ReadScenario(const std::string& name_or_path,
                      const std::vector<std::string>& changes = {});

/// The YAML text of a shipped scenario by name, else of a scenario file. Throws InvalidConfig as
/// ReadScenario.
std::string ScenarioText(const std::string& name_or_path);

/// Reads a scenario from YAML. `where` is the file named in messages; a relative `replay` is looked
/// for beside it. Throws InvalidConfig with file:line:column for bad YAML, an unknown key, effect,
/// preset or terrain kind (with the nearest known one), and a value of the wrong type, shape or
/// range.
Scenario ParseScenario(const std::string& yaml_text, const std::string& where);

/// The scenario as YAML: ParseScenario reads the same one from it, beside the same files where the
/// path of its replay is a relative one.
std::string FormatScenario(const Scenario& scenario);

}  // namespace dn
