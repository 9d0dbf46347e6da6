#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/names.h>
#include <dn/sim/scenario.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "effects.h"
#include "scenario_limits.h"
#include "scenario_section.h"

namespace dn {
namespace {

constexpr double kSecondsPerWeek = 604800.0;

Geodetic ReadOrigin(const ScenarioSection& root) {
  const Eigen::Vector3d origin = root.Vector("origin_deg_m");
  if (std::abs(origin.x()) >= 90.0) {
    root.Fail("origin_deg_m", "the latitude must lie between -90 and 90 deg");
  }
  if (std::abs(origin.y()) > 360.0) {
    root.Fail("origin_deg_m", "the longitude must lie between -360 and 360 deg");
  }
  if (std::abs(origin.z()) > 1e6) {
    root.Fail("origin_deg_m", "the height must lie between -1e6 and 1e6 m");
  }
  return {origin.x() * kRadPerDeg, origin.y() * kRadPerDeg, origin.z()};
}

PlannedLine ReadLine(const ScenarioSection& plan, const std::vector<double>& row) {
  PlannedLine line{{row[0], row[1]}, {row[2], row[3]}, row[4], row[5]};
  if (!(line.speed_mps > 0.0)) plan.Fail("lines", "the speed of a line must be positive");
  if ((line.end_en_m - line.start_en_m).norm() < line.speed_mps) {
    plan.Fail("lines", "a line must be flown for at least 1 s");
  }
  return line;
}

TurbulenceScenario ReadTurbulence(const ScenarioSection& plan) {
  const ScenarioSection s =
      plan.Sub("turbulence", {"roll_deg", "pitch_deg", "heading_deg", "speed_m_s", "height_m"});
  TurbulenceScenario t;
  t.roll_rad = s.NotNegative("roll_deg", 0.0) * kRadPerDeg;
  t.pitch_rad = s.NotNegative("pitch_deg", 0.0) * kRadPerDeg;
  t.heading_rad = s.NotNegative("heading_deg", 0.0) * kRadPerDeg;
  t.speed_mps = s.NotNegative("speed_m_s", 0.0);
  t.height_m = s.NotNegative("height_m", 0.0);
  return t;
}

/// Turbulence that would turn the aircraft over or stop it is a mistake.
void CheckTurbulence(const ScenarioSection& root, const PlanScenario& plan) {
  constexpr double kMostAttitude_rad = 10.0 * kRadPerDeg;
  constexpr double kMostSpeedShare = 0.1;
  const TurbulenceScenario& t = plan.turbulence;
  if (std::max({t.roll_rad, t.pitch_rad, t.heading_rad}) > kMostAttitude_rad) {
    root.Fail("plan", "turbulence in attitude may be up to 10 deg rms");
  }
  for (const PlannedLine& line : plan.lines) {
    if (t.speed_mps > kMostSpeedShare * line.speed_mps) {
      root.Fail("plan", "turbulence.speed_m_s may be up to a tenth of every line's speed");
    }
  }
}

PlanScenario ReadPlan(const ScenarioSection& root, const std::string& file) {
  const ScenarioSection s = root.Sub("plan", {"warm_up_s", "lines", "bank_deg", "turbulence",
                                              "crab_deg", "stabilised_mount", "replay"});
  PlanScenario plan;
  plan.warm_up_s = s.NotNegative("warm_up_s", 0.0);
  plan.where = s.PlaceOf("lines");
  for (const auto& row : s.Rows("lines", 6)) plan.lines.push_back(ReadLine(s, row));
  const double bank_deg = s.Positive("bank_deg", 25.0);
  if (bank_deg > 60.0) s.Fail("bank_deg", "must be at most 60");
  plan.bank_rad = bank_deg * kRadPerDeg;
  plan.turbulence = ReadTurbulence(s);
  plan.crab_rad = s.Number("crab_deg", 0.0) * kRadPerDeg;
  if (std::abs(plan.crab_rad) > 45.0 * kRadPerDeg) s.Fail("crab_deg", "must be within 45");
  plan.stabilised_mount = s.Flag("stabilised_mount", false);
  if (s.Has("replay")) {
    plan.replay = std::filesystem::path(file).parent_path() / s.Text("replay");
  } else if (plan.lines.empty()) {
    s.Fail("lines", "at least one line is required (or replay: a trajectory file)");
  }
  CheckTurbulence(root, plan);
  return plan;
}

TerrainKind ReadTerrainKind(const ScenarioSection& s) {
  static const std::map<std::string, TerrainKind> kinds{{"built_up", TerrainKind::kBuiltUp},
                                                        {"mixed", TerrainKind::kMixed},
                                                        {"natural", TerrainKind::kNatural},
                                                        {"mountain", TerrainKind::kMountain},
                                                        {"flat", TerrainKind::kFlat}};
  if (!s.Has("kind")) return TerrainKind::kMixed;
  const auto found = kinds.find(s.Text("kind"));
  if (found != kinds.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& kind : kinds) names.push_back(kind.first);
  s.Fail("kind", "unknown terrain '" + s.Text("kind") + "'; did you mean '" +
                     NearestName(s.Text("kind"), names) + "'? Known: " + JoinNames(names));
}

TerrainScenario ReadTerrain(const ScenarioSection& root) {
  const ScenarioSection s = root.Sub("terrain", {"kind", "relief_m", "wavelength_m", "base_m",
                                                 "buildings_per_km2", "trees_per_km2", "seed"});
  TerrainScenario terrain;
  terrain.kind = ReadTerrainKind(s);
  terrain.relief_m = s.NotNegative("relief_m", 0.0);
  terrain.wavelength_m = s.Positive("wavelength_m", 1000.0);
  terrain.base_m = s.Number("base_m", 0.0);
  terrain.buildings_per_km2 = s.NotNegative("buildings_per_km2", 0.0);
  terrain.trees_per_km2 = s.NotNegative("trees_per_km2", 0.0);
  terrain.seed = static_cast<std::uint64_t>(s.Count("seed", 1));
  return terrain;
}

/// Units of the noise keys of one kind of sensor.
struct NoiseKeys {
  std::string white, bias, walk;
  double (*white_to_si)(double);
  double (*bias_to_si)(double);
  double (*walk_to_si)(double);
};

const NoiseKeys& GyroKeys() {
  static const NoiseKeys keys{"white_deg_sqrt_h",   "sigma_deg_h",
                              "sigma_deg_h_sqrt_h", RadPerSqrtSFromDegPerSqrtHour,
                              RadpsFromDegPerHour,  RadpsPerSqrtSFromDegPerHourPerSqrtHour};
  return keys;
}

const NoiseKeys& AccelKeys() {
  static const NoiseKeys keys{"white_m_s_sqrt_h", "sigma_mg",
                              "sigma_mg_sqrt_h",  MpsPerSqrtSFromMpsPerSqrtHour,
                              Mps2FromMg,         Mps2PerSqrtSFromMgPerSqrtHour};
  return keys;
}

BiasProcess ReadProcess(const ScenarioSection& s, const NoiseKeys& keys) {
  const std::vector<std::string> types{"random_constant", "gauss_markov", "random_walk"};
  const std::string type = s.Text("type");
  BiasProcess process;
  if (type == "random_walk") {
    process.type = BiasProcess::Type::kRandomWalk;
    process.sigma = keys.walk_to_si(s.Positive(keys.walk));
  } else if (type == "random_constant" || type == "gauss_markov") {
    process.sigma = keys.bias_to_si(s.Positive(keys.bias));
  } else {
    s.Fail("type",
           "unknown process '" + type + "'; did you mean '" + NearestName(type, types) + "'?");
  }
  if (type == "gauss_markov") {
    process.type = BiasProcess::Type::kGaussMarkov;
    process.tau_s = s.Positive("tau_s");
  } else if (s.Has("tau_s")) {
    s.Fail("tau_s", "belongs to gauss_markov only");
  }
  return process;
}

/// Explicit noise of one sensor over that of the preset; true when there was any.
bool ReadNoise(const ScenarioSection& imu, const std::string& sensor, const NoiseKeys& keys,
               SensorNoise& noise) {
  if (!imu.Has(sensor)) return false;
  const ScenarioSection s = imu.Sub(sensor, {keys.white, "processes"});
  if (s.Has(keys.white)) noise.white = keys.white_to_si(s.Positive(keys.white));
  if (s.Has("processes")) {
    noise.processes.clear();
    for (const ScenarioSection& process :
         s.List("processes", {"type", keys.bias, keys.walk, "tau_s"})) {
      noise.processes.push_back(ReadProcess(process, keys));
    }
  }
  if (noise.white <= 0.0) s.Fail(keys.white, "is required where there is no preset");
  return true;
}

ImuScenario ReadImuScenario(const ScenarioSection& root) {
  const ScenarioSection s = root.Sub("imu", {"rate_hz", "preset", "gyro", "accel"});
  ImuScenario imu;
  imu.rate_hz = s.Positive("rate_hz", 200.0);
  if (imu.rate_hz < 10.0 || imu.rate_hz > 2000.0) s.Fail("rate_hz", "must lie in 10 to 2000");
  if (s.Has("preset")) {
    imu.preset = s.Text("preset");
    try {
      imu.model = ImuPreset(*imu.preset);
    } catch (const InvalidConfig& error) {
      s.Fail("preset", error.what());
    }
  } else if (!s.Has("gyro") || !s.Has("accel")) {
    s.Fail("preset", "is required unless both gyro and accel are given");
  }
  const bool gyro = ReadNoise(s, "gyro", GyroKeys(), imu.model.gyro);
  const bool accel = ReadNoise(s, "accel", AccelKeys(), imu.model.accel);
  if (gyro || accel) imu.preset.reset();
  return imu;
}

GnssScenario ReadGnssScenario(const ScenarioSection& root) {
  const ScenarioSection s = root.Sub("gnss", {"rate_hz", "sigma_enu_m", "lever_arm_m", "velocity"});
  GnssScenario gnss;
  gnss.rate_hz = s.Positive("rate_hz", 1.0);
  if (gnss.rate_hz > 100.0) s.Fail("rate_hz", "must be at most 100");
  gnss.sigma_enu_m = s.Vector("sigma_enu_m", gnss.sigma_enu_m);
  if (!(gnss.sigma_enu_m.minCoeff() > 0.0)) s.Fail("sigma_enu_m", "must be positive");
  gnss.lever_arm_b_m = s.Vector("lever_arm_m", Eigen::Vector3d::Zero());
  gnss.velocity = s.Flag("velocity", false);
  return gnss;
}

Eigen::Matrix3d ReadRotation(const ScenarioSection& s) {
  const auto rows = s.Rows("R_sensor_to_body", 3);
  if (rows.size() != 3) s.Fail("R_sensor_to_body", "must be 3 rows of 3 numbers");
  Eigen::Matrix3d R;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      R(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
    }
  }
  try {
    return CheckedRotation(R);
  } catch (const InvalidInput& error) {
    s.Fail("R_sensor_to_body", error.what());
  }
}

LidarScenario ReadLidar(const ScenarioSection& root) {
  const ScenarioSection s = root.Sub(
      "lidar", {"R_sensor_to_body", "scan_axis", "nadir_axis", "lever_arm_m", "boresight_deg",
                "fov_deg", "pulse_rate_hz", "gsd_m", "beam_divergence_mrad"});
  LidarScenario lidar;
  if (s.Has("R_sensor_to_body")) lidar.mounting.R_bs_nominal = ReadRotation(s);
  lidar.mounting.lever_arm_b_m = s.Vector("lever_arm_m", Eigen::Vector3d::Zero());
  lidar.mounting.boresight_rad = kRadPerDeg * s.Vector("boresight_deg", Eigen::Vector3d::Zero());
  lidar.scan_axis_s = s.Vector("scan_axis", lidar.scan_axis_s);
  lidar.nadir_axis_s = s.Vector("nadir_axis", lidar.nadir_axis_s);
  constexpr double kSquare = 1e-6;
  for (const auto& [key, axis] :
       {std::pair{"scan_axis", lidar.scan_axis_s}, std::pair{"nadir_axis", lidar.nadir_axis_s}}) {
    if (std::abs(axis.norm() - 1.0) > kSquare) s.Fail(key, "must be a unit vector");
  }
  if (std::abs(lidar.scan_axis_s.dot(lidar.nadir_axis_s)) > kSquare) {
    s.Fail("nadir_axis", "must be perpendicular to scan_axis");
  }
  if ((lidar.mounting.R_bs_nominal * lidar.nadir_axis_s).z() <= 0.0) {
    s.Fail("nadir_axis", "points above the horizon when mounted by R_sensor_to_body");
  }
  const double fov_deg = s.Positive("fov_deg", 60.0);
  if (fov_deg > 150.0) s.Fail("fov_deg", "must be at most 150");
  lidar.fov_rad = fov_deg * kRadPerDeg;
  lidar.pulse_rate_hz = s.Positive("pulse_rate_hz", 100000.0);
  lidar.gsd_m = s.Positive("gsd_m");
  lidar.beam_divergence_rad = 1e-3 * s.NotNegative("beam_divergence_mrad", 0.0);
  return lidar;
}

PairScenario ReadPairScenario(const ScenarioSection& root, double gsd_m) {
  const ScenarioSection s = root.Sub("pairs", {"count", "sigma_p_m"});
  PairScenario pairs;
  pairs.where = s.where();
  pairs.count = s.Count("count", 3000);
  pairs.sigma_p_m = s.Positive("sigma_p_m", gsd_m / 2.0 / std::sqrt(3.0));
  return pairs;
}

// Sizes that only make sense above zero, shares of a whole.
void CheckEffectValues(const ScenarioSection& s, const Effect& effect) {
  const std::string& name = effect.name;
  const auto ends_with = [&](const std::string& end) {
    return name.size() >= end.size() &&
           name.compare(name.size() - end.size(), end.size(), end) == 0;
  };
  if (ends_with("_noise_scale") && !(effect.value[0] > 0.0)) s.Fail("value", "must be positive");
  if (ends_with("_bias_process") || name == "gnss_correlated_noise") {
    if (!(effect.value.back() > 0.0)) s.Fail("value", "the time constant must be positive");
  }
  if (ends_with("_outliers") &&
      !(effect.value[0] >= 0.0 && effect.value[0] <= 1.0 && effect.value[1] >= 0.0)) {
    s.Fail("value", "must be a share between 0 and 1 and a size of at least 0 m");
  }
}

void ReadTiming(const ScenarioSection& s, const EffectDescription& description, Effect* effect) {
  using Timing = EffectDescription::Timing;
  const auto check = [&](const char* key, bool belongs) {
    if (s.Has(key) && !belongs) s.Fail(key, "does not belong to '" + effect->name + "'");
    if (!s.Has(key) && belongs) s.Fail(key, "is missing; '" + effect->name + "' needs it");
  };
  check("window_s", description.timing == Timing::kWindow);
  check("t0_s", description.timing == Timing::kStart);
  if (description.timing == Timing::kStart) effect->t0_s = s.Number("t0_s");
  if (description.timing != Timing::kWindow) return;
  const std::vector<double> window_s = s.Numbers("window_s");
  if (window_s.size() != 2 || window_s[1] <= window_s[0]) {
    s.Fail("window_s", "must be [begin, end] with begin before end");
  }
  effect->window_s = {window_s[0], window_s[1]};
}

Effect ReadEffect(const ScenarioSection& s) {
  std::vector<std::string> names;
  for (const EffectDescription& known : KnownEffects()) names.push_back(known.name);
  Effect effect;
  effect.name = s.Text("effect");
  effect.where = s.where();
  const auto known = std::find(names.begin(), names.end(), effect.name);
  if (known == names.end()) {
    s.Fail("effect", "unknown effect '" + effect.name + "'; did you mean '" +
                         NearestName(effect.name, names) + "'?");
  }
  const EffectDescription& description =
      KnownEffects()[static_cast<std::size_t>(known - names.begin())];
  if (!description.simulated) {
    s.Fail("effect", "'" + effect.name + "' is not simulated by this version; simulated are: " +
                         JoinNames(SimulatedEffects()));
  }
  if (description.values > 0) {
    effect.value = s.Numbers("value");
  } else if (s.Has("value")) {
    s.Fail("value", "'" + effect.name + "' has no value");
  }
  if (effect.value.size() != description.values) {
    s.Fail("value", "'" + effect.name + "' takes " + std::to_string(description.values) +
                        (description.values == 1 ? " number" : " numbers"));
  }
  CheckEffectValues(s, effect);
  ReadTiming(s, description, &effect);
  return effect;
}

YAML::Node Load(const std::string& yaml_text, const std::string& file) {
  try {
    return YAML::Load(yaml_text);
  } catch (const YAML::Exception& error) {
    throw InvalidConfig("not valid YAML: " + error.msg,
                        {file, error.mark.line + 1, error.mark.column + 1});
  }
}

FileLocation PlaceIn(const YAML::Node& root, const std::string& section, const std::string& key,
                     const std::string& file) {
  const YAML::Mark mark = root[section][key].Mark();
  return {file, mark.line + 1, mark.column + 1};
}

}  // namespace

Scenario ParseScenario(const std::string& yaml_text, const std::string& where) {
  const YAML::Node node = Load(yaml_text, where);
  const ScenarioSection root(node, "", {where, 1, 1},
                             {"name", "origin_deg_m", "start_s", "plan", "terrain", "imu", "gnss",
                              "lidar", "pairs", "strips", "effects"});
  Scenario scenario;
  scenario.name = root.Text("name");
  scenario.origin = ReadOrigin(root);
  scenario.start_s = root.NotNegative("start_s", 0.0);
  if (scenario.start_s >= kSecondsPerWeek) root.Fail("start_s", "must be less than a week");
  scenario.plan = ReadPlan(root, where);
  scenario.terrain = ReadTerrain(root);
  scenario.imu = ReadImuScenario(root);
  scenario.gnss = ReadGnssScenario(root);
  scenario.lidar = ReadLidar(root);
  scenario.pairs = ReadPairScenario(root, scenario.lidar.gsd_m);
  if (root.Flag("strips", false)) {
    root.Fail("strips", "point clouds are not simulated by this version; set strips: false");
  }
  for (const ScenarioSection& entry :
       root.List("effects", {"effect", "value", "window_s", "t0_s"})) {
    scenario.effects.push_back(ReadEffect(entry));
  }
  CheckLimits(scenario, [&](const std::string& section, const std::string& key) {
    return PlaceIn(node, section, key, where);
  });
  return scenario;
}

}  // namespace dn
