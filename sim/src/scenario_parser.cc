#include <dn/config/yaml_value.h>
#include <dn/files/yaml_sections.h>
#include <dn/geo/local_frame.h>
#include <dn/names.h>
#include <dn/sim/scenario.h>

#include <algorithm>
#include <cmath>

#include "scenario_limits.h"
#include "scenario_words.h"
#include "vibration_section.h"

namespace dn {
namespace {

constexpr double kSecondsPerWeek = 604800.0;
constexpr double kMostWater = 0.9;
constexpr double kSmallestSpan_m = 0.3, kLargestSpan_m = 100.0;
// A slower filter would not pass the motion of the platform.
constexpr double kSlowestFilter_hz = 2.0;
constexpr std::size_t kMostLines = 1000;
constexpr std::size_t kMostEffects = 100;

Geodetic ReadOrigin(const YamlValue& value) {
  const Eigen::Vector3d origin = ReadVector3(value);
  if (std::abs(origin.x()) >= 90.0) value.Fail("the latitude must lie between -90 and 90 deg");
  if (std::abs(origin.y()) > 360.0) value.Fail("the longitude must lie between -360 and 360 deg");
  if (std::abs(origin.z()) > 1e6) value.Fail("the height must lie between -1e6 and 1e6 m");
  return {origin.x() * kRadPerDeg, origin.y() * kRadPerDeg, origin.z()};
}

PlannedLine ReadPlannedLine(const YamlValue& item) {
  const Eigen::VectorXd row = ReadNumbers(item, 6);
  PlannedLine line{{row[0], row[1]}, {row[2], row[3]}, row[4], row[5]};
  if (!(line.speed_mps > 0.0)) item.Fail("the speed of a line must be positive");
  if ((line.end_en_m - line.start_en_m).norm() < line.speed_mps) {
    item.Fail("a line must be flown for at least 1 s");
  }
  return line;
}

TurbulenceScenario ReadTurbulence(const YamlValue& s) {
  ExpectMapOrAbsent(s, {"roll_deg", "pitch_deg", "heading_deg", "speed_m_s", "height_m", "spectrum",
                        "wingspan_m"});
  TurbulenceScenario t;
  t.roll_rad = ReadNotNegativeOr(s["roll_deg"], 0.0) * kRadPerDeg;
  t.pitch_rad = ReadNotNegativeOr(s["pitch_deg"], 0.0) * kRadPerDeg;
  t.heading_rad = ReadNotNegativeOr(s["heading_deg"], 0.0) * kRadPerDeg;
  t.speed_mps = ReadNotNegativeOr(s["speed_m_s"], 0.0);
  t.height_m = ReadNotNegativeOr(s["height_m"], 0.0);
  if (s["spectrum"]) t.spectrum = s["spectrum"].Choice(TurbulenceWords());
  t.wingspan_m = ReadPositiveOr(s["wingspan_m"], 10.0);
  if (t.wingspan_m < kSmallestSpan_m || t.wingspan_m > kLargestSpan_m) {
    s["wingspan_m"].Fail("must lie between 0.3 and 100");
  }
  if (s["wingspan_m"] && t.spectrum != TurbulenceSpectrum::kDryden) {
    s["wingspan_m"].Fail("is only allowed with spectrum: dryden");
  }
  return t;
}

/// Reads the strips of a replayed trajectory. Their names become parts of file names.
std::vector<StripInterval> ReadReplayedStrips(const YamlValue& s) {
  if (s["strips"] && !s["replay"])
    s["strips"].Fail("is only allowed with replay; otherwise the lines are the strips");
  std::vector<StripInterval> strips = ReadStrips(s["strips"]);
  for (const StripInterval& strip : strips) ExpectPlainName(s["strips"], strip.name);
  return strips;
}

/// Throws InvalidConfig for turbulence that would turn the aircraft over or stop it.
void CheckTurbulence(const YamlValue& turbulence, const PlanScenario& plan) {
  constexpr double kMostAttitude_rad = 10.0 * kRadPerDeg;
  constexpr double kMostSpeedShare = 0.1;
  const TurbulenceScenario& t = plan.turbulence;
  if (std::max({t.roll_rad, t.pitch_rad, t.heading_rad}) > kMostAttitude_rad) {
    turbulence.Fail("turbulence in attitude must not exceed 10 deg rms");
  }
  for (const PlannedLine& line : plan.lines) {
    if (t.speed_mps > kMostSpeedShare * line.speed_mps) {
      turbulence["speed_m_s"].Fail("must not exceed a tenth of the speed of any line");
    }
  }
}

PlanScenario ReadPlan(const YamlValue& s, const std::string& file) {
  ExpectMapOrAbsent(s, {"warm_up_s", "lines", "bank_deg", "turbulence", "crab_deg",
                        "stabilised_mount", "vibration", "replay", "strips"});
  PlanScenario plan;
  plan.warm_up_s = ReadNotNegativeOr(s["warm_up_s"], 0.0);
  plan.where = s[s["strips"] ? "strips" : "lines"].where();
  if (s["lines"]) {
    for (const YamlValue& row : s["lines"].List(kMostLines))
      plan.lines.push_back(ReadPlannedLine(row));
  }
  const double bank_deg = ReadPositiveOr(s["bank_deg"], 25.0);
  if (bank_deg > 60.0) s["bank_deg"].Fail("must be at most 60");
  plan.bank_rad = bank_deg * kRadPerDeg;
  plan.turbulence = ReadTurbulence(s["turbulence"]);
  plan.vibration = ReadVibration(s["vibration"]);
  plan.crab_rad = ReadNumberOr(s["crab_deg"], 0.0) * kRadPerDeg;
  if (std::abs(plan.crab_rad) > 45.0 * kRadPerDeg)
    s["crab_deg"].Fail("must lie between -45 and 45");
  plan.stabilised_mount = ReadBoolOr(s["stabilised_mount"], false);
  if (s["replay"]) {
    plan.replay = std::filesystem::path(file).parent_path() / s["replay"].Text();
  } else if (plan.lines.empty()) {
    s["lines"].Fail("at least one line is required (or replay: a trajectory file)");
  }
  plan.strips = ReadReplayedStrips(s);
  CheckTurbulence(s["turbulence"], plan);
  return plan;
}

/// Returns an assumed roughness of the ground under point clouds (rms, m), from paved or mown
/// ground to scree.
double UsualRoughness(TerrainKind kind) {
  switch (kind) {
    case TerrainKind::kBuiltUp:
      return 0.03;
    case TerrainKind::kMixed:
      return 0.05;
    case TerrainKind::kNatural:
      return 0.1;
    case TerrainKind::kMountain:
      return 0.3;
    case TerrainKind::kFlat:
      return 0.02;
    case TerrainKind::kForest:
      return 0.08;
    case TerrainKind::kOrchard:
    case TerrainKind::kFields:
      return 0.04;
    case TerrainKind::kTown:
      return 0.03;
    case TerrainKind::kQuarry:
      return 0.1;
  }
  return 0.0;
}

/// Numbers of objects per km^2.
struct Objects {
  double buildings = 0.0, trees = 0.0, cars = 0.0;
};

/// Returns the numbers of objects if the scenario does not give them. Only the detailed kinds have
/// objects by default.
Objects UsualObjects(TerrainKind kind) {
  switch (kind) {
    case TerrainKind::kForest:
      return {0.0, 45000.0, 0.0};
    case TerrainKind::kOrchard:
      return {0.0, 50000.0, 0.0};
    case TerrainKind::kTown:
      return {900.0, 3000.0, 2000.0};
    case TerrainKind::kQuarry:
    case TerrainKind::kFields:
      return {0.0, 200.0, 0.0};
    default:
      return {};
  }
}

/// Returns whether a terrain of this kind may have woods_share.
bool MayHaveWoods(TerrainKind kind) {
  return kind == TerrainKind::kMixed || kind == TerrainKind::kNatural ||
         kind == TerrainKind::kMountain;
}

/// Reads the keys that only a terrain with plants has.
void ReadDetails(const YamlValue& s, TerrainScenario* terrain) {
  terrain->woods_share = ReadNotNegativeOr(s["woods_share"], 0.0);
  if (terrain->woods_share > 1.0) s["woods_share"].Fail("must be at most 1");
  if (terrain->woods_share > 0.0 && !MayHaveWoods(terrain->kind)) {
    s["woods_share"].Fail("is only allowed on a terrain of kind mixed, natural or mountain");
  }
  for (const char* key : {"cars_per_km2", "conifer_share", "leaves"}) {
    if (s[key] && !HasScene(*terrain)) {
      s[key].Fail(
          "is only allowed on a terrain of kind forest, orchard, town, quarry or fields, or with "
          "woods_share");
    }
  }
  terrain->cars_per_km2 = ReadNotNegativeOr(s["cars_per_km2"], UsualObjects(terrain->kind).cars);
  terrain->conifer_share = ReadNotNegativeOr(s["conifer_share"], terrain->conifer_share);
  if (terrain->conifer_share > 1.0) s["conifer_share"].Fail("must be at most 1");
  terrain->leaves = ReadBoolOr(s["leaves"], true);
}

/// clouds: true if point clouds are simulated. If only pairs are simulated, the ground is smooth by
/// default.
TerrainScenario ReadTerrain(const YamlValue& s, bool clouds) {
  ExpectMapOrAbsent(s, {"kind", "relief_m", "wavelength_m", "base_m", "buildings_per_km2",
                        "trees_per_km2", "roughness_m", "water_share", "woods_share",
                        "cars_per_km2", "conifer_share", "leaves", "seed"});
  TerrainScenario terrain;
  if (s["kind"]) terrain.kind = s["kind"].Choice(TerrainWords());
  terrain.relief_m = ReadNotNegativeOr(s["relief_m"], 0.0);
  terrain.wavelength_m = ReadPositiveOr(s["wavelength_m"], 1000.0);
  terrain.base_m = ReadNumberOr(s["base_m"], 0.0);
  const Objects usual = UsualObjects(terrain.kind);
  terrain.buildings_per_km2 = ReadNotNegativeOr(s["buildings_per_km2"], usual.buildings);
  terrain.trees_per_km2 = ReadNotNegativeOr(s["trees_per_km2"], usual.trees);
  ReadDetails(s, &terrain);
  terrain.roughness_m =
      ReadNotNegativeOr(s["roughness_m"], clouds ? UsualRoughness(terrain.kind) : 0.0);
  terrain.water_share = ReadNotNegativeOr(s["water_share"], 0.0);
  if (terrain.water_share > kMostWater) s["water_share"].Fail("must be at most 0.9");
  if (terrain.water_share > 0.0 &&
      (terrain.relief_m == 0.0 || terrain.kind == TerrainKind::kFlat)) {
    s["water_share"].Fail("water needs a relief: flat ground is either all water or all dry");
  }
  if (s["seed"]) terrain.seed = static_cast<std::uint64_t>(s["seed"].Integer(0));
  return terrain;
}

ImuScenario ReadImuScenario(const YamlValue& s) {
  ExpectMapOrAbsent(s, {"rate_hz", "preset", "gyro", "accel", "sampling", "filter_hz"});
  ImuScenario imu;
  imu.rate_hz = ReadPositiveOr(s["rate_hz"], 200.0);
  if (imu.rate_hz < 10.0 || imu.rate_hz > 2000.0) s["rate_hz"].Fail("must lie between 10 and 2000");
  imu.model = ReadImuNoise(s, "preset");
  if (s["sampling"]) imu.sampling = s["sampling"].Choice(SamplingWords());
  if (s["filter_hz"]) imu.filter_hz = s["filter_hz"].Number();
  if (imu.filter_hz.value_or(imu.rate_hz) < kSlowestFilter_hz ||
      imu.filter_hz.value_or(0.0) > imu.rate_hz) {
    s["filter_hz"].Fail("must lie between 2 Hz and rate_hz");
  }
  if (s["preset"] && !s["gyro"] && !s["accel"]) imu.preset = ReadName(s["preset"]);
  return imu;
}

GnssScenario ReadGnssScenario(const YamlValue& s) {
  ExpectMapOrAbsent(s, {"rate_hz", "sigma_enu_m", "lever_arm_m", "velocity", "processes"});
  GnssScenario gnss;
  gnss.rate_hz = ReadPositiveOr(s["rate_hz"], 1.0);
  if (gnss.rate_hz > 100.0) s["rate_hz"].Fail("must be at most 100");
  if (s["sigma_enu_m"]) gnss.sigma_enu_m = ReadPositiveVector3(s["sigma_enu_m"]);
  gnss.lever_arm_b_m = ReadVector3Or(s["lever_arm_m"], Eigen::Vector3d::Zero());
  gnss.velocity = ReadBoolOr(s["velocity"], false);
  gnss.processes = ReadGnssProcesses(s);
  return gnss;
}

/// Reads the keys of several returns. detailed: true over a terrain with plants, where several are
/// the default.
void ReadReturns(const YamlValue& s, bool detailed, LidarScenario* lidar) {
  constexpr long kMostReturns = 5;
  lidar->max_returns = detailed ? static_cast<int>(kMostReturns) : 1;
  if (s["max_returns"]) lidar->max_returns = static_cast<int>(s["max_returns"].Integer(1));
  if (lidar->max_returns > kMostReturns) s["max_returns"].Fail("must be at most 5");
  lidar->range_resolution_m = ReadPositiveOr(s["range_resolution_m"], lidar->range_resolution_m);
  const bool several = lidar->max_returns > 1;
  lidar->noise_share = ReadNotNegativeOr(s["noise_share"], detailed && several ? 1e-4 : 0.0);
  if (lidar->noise_share > 0.5) s["noise_share"].Fail("must be at most 0.5");
  if (lidar->noise_share > 0.0 && !several) {
    s["noise_share"].Fail("needs max_returns of 2 or more");
  }
  lidar->scan_variation = ReadNotNegativeOr(s["scan_variation"], detailed ? 0.02 : 0.0);
  if (lidar->scan_variation > 0.1) s["scan_variation"].Fail("must be at most 0.1");
}

/// Reads errors of beams, one number for each.
std::vector<double> ReadBeamErrors(const YamlValue& value, int beams, double to_si) {
  if (!value) return {};
  std::vector<double> errors = ReadNumberList(value);
  if (errors.size() != static_cast<std::size_t>(beams)) {
    value.Fail("has " + std::to_string(errors.size()) +
               " numbers, must have one per beam: " + std::to_string(beams));
  }
  for (double& error : errors) error *= to_si;
  return errors;
}

BeamScenario ReadBeamScenario(const YamlValue& s) {
  s.ExpectMap({"angles_deg", "rotation_hz", "angle_sigma_deg", "range_offset_sigma_m",
               "angle_error_deg", "range_error_m"});
  const BeamConfig usual;
  BeamScenario beams;
  beams.angles_rad = ReadBeamAngles(s["angles_deg"]);
  beams.rotation_hz = ReadPositiveOr(s["rotation_hz"], beams.rotation_hz);
  beams.angle_sigma_rad = usual.angle_sigma_rad;
  beams.range_sigma_m = usual.range_sigma_m;
  ReadBeamSigmas(s, &beams.angle_sigma_rad, &beams.range_sigma_m);
  beams.angle_error_rad = ReadBeamErrors(s["angle_error_deg"], beams.count(), kRadPerDeg);
  beams.range_error_m = ReadBeamErrors(s["range_error_m"], beams.count(), 1.0);
  return beams;
}

/// Reads the arrangement of the beams; several beams belong to a rotating scanner.
void ReadPattern(const YamlValue& s, LidarScenario* lidar) {
  if (s["beams"]) {
    lidar->pattern = ScanPattern::kRotating;
    lidar->beams = ReadBeamScenario(s["beams"]);
  }
  if (!s["pattern"]) return;
  const ScanPattern pattern = s["pattern"].Choice(ScanPatternWords());
  if (pattern == ScanPattern::kRotating && !s["beams"]) {
    s["pattern"].Fail("needs `beams`: {angles_deg: [...]}");
  }
  if (pattern != ScanPattern::kRotating && s["beams"]) {
    s["pattern"].Fail("must be rotating, or absent, for a scanner with several beams");
  }
  lidar->pattern = pattern;
}

/// `name` is that of a scanner in a list; it is empty without a list. detailed: true over a
/// terrain with plants.
LidarScenario ReadLidar(const YamlValue& s, const std::string& name, bool detailed) {
  std::vector<std::string> keys{"R_sensor_to_body",
                                "scan_axis",
                                "nadir_axis",
                                "lever_arm_m",
                                "boresight_deg",
                                "fov_deg",
                                "pattern",
                                "pulse_rate_hz",
                                "gsd_m",
                                "beam_divergence_mrad",
                                "sigma_range_m",
                                "max_returns",
                                "range_resolution_m",
                                "noise_share",
                                "scan_variation",
                                "beams"};
  if (!name.empty()) keys.emplace_back("name");
  ExpectMapOrAbsent(s, keys);
  LidarScenario lidar;
  lidar.name = name;
  const ScannerAxes axes = ReadScannerAxes(s, false);
  lidar.mounting.R_bs_nominal = axes.R_bs_nominal;
  lidar.scan_axis_s = axes.scan_axis_s;
  lidar.nadir_axis_s = axes.nadir_axis_s;
  lidar.mounting.lever_arm_b_m = ReadVector3Or(s["lever_arm_m"], Eigen::Vector3d::Zero());
  lidar.mounting.boresight_rad =
      kRadPerDeg * ReadVector3Or(s["boresight_deg"], Eigen::Vector3d::Zero());
  const double fov_deg = ReadPositiveOr(s["fov_deg"], 60.0);
  if (fov_deg > 150.0) s["fov_deg"].Fail("must be at most 150");
  lidar.fov_rad = fov_deg * kRadPerDeg;
  ReadPattern(s, &lidar);
  lidar.pulse_rate_hz = ReadPositiveOr(s["pulse_rate_hz"], 100000.0);
  lidar.gsd_m = ReadPositive(s["gsd_m"]);
  lidar.beam_divergence_rad = 1e-3 * ReadNotNegativeOr(s["beam_divergence_mrad"], 0.0);
  lidar.sigma_range_m = ReadNotNegativeOr(s["sigma_range_m"], 0.02);
  ReadReturns(s, detailed, &lidar);
  return lidar;
}

/// Returns the first scanner; appends the others of a list to `more`.
LidarScenario ReadScanners(const YamlValue& s, bool detailed, std::vector<LidarScenario>* more) {
  if (!s || s.IsMap()) return ReadLidar(s, "", detailed);
  std::vector<std::string> names;
  std::vector<LidarScenario> all;
  for (const YamlValue& item : s.List(kMostScanners)) {
    names.push_back(ReadScannerName(item, names));
    all.push_back(ReadLidar(item, names.back(), detailed));
  }
  if (all.empty()) s.Fail("must have at least one scanner");
  more->assign(all.begin() + 1, all.end());
  return all.front();
}

PairScenario ReadPairScenario(const YamlValue& s, double gsd_m, bool several_scanners) {
  ExpectMapOrAbsent(s, {"count", "between", "sigma_p_m", "shared_error"});
  PairScenario pairs;
  pairs.where = s.where();
  pairs.count = s["count"] ? static_cast<long>(s["count"].Integer(0)) : 3000;
  if (s["between"] && !several_scanners) s["between"].Fail("needs several scanners under lidar");
  if (several_scanners) {
    pairs.between = s["between"] ? static_cast<long>(s["between"].Integer(0)) : pairs.count;
  }
  pairs.sigma_p_m = ReadPositiveOr(s["sigma_p_m"], gsd_m / 2.0 / std::sqrt(3.0));
  const YamlValue shared = s["shared_error"];
  if (!shared) return pairs;
  ExpectMapOrAbsent(shared, {"fraction", "length_m"});
  pairs.shared_fraction = ReadPositive(shared["fraction"]);
  if (pairs.shared_fraction > 1.0) shared["fraction"].Fail("must be at most 1");
  pairs.shared_length_m = ReadPositive(shared["length_m"]);
  return pairs;
}

ControlScenario ReadControlScenario(const YamlValue& s) {
  constexpr long kMostPoints = 1000;
  ExpectMapOrAbsent(s, {"points", "checks", "corners", "corner_checks", "sigma_m"});
  ControlScenario control;
  const auto read = [&](const char* key, long* number) {
    if (s[key]) *number = static_cast<long>(s[key].Integer(0));
    if (*number > kMostPoints) s.Fail("all points together must be at most 1000");
  };
  read("points", &control.points);
  read("checks", &control.checks);
  read("corners", &control.corners);
  read("corner_checks", &control.corner_checks);
  if (s["sigma_m"]) control.sigma_enu_m = ReadPositiveVector3(s["sigma_m"]);
  if (control.size() > kMostPoints) s.Fail("all points together must be at most 1000");
  return control;
}

const EffectSpec& RequireEffect(const YamlValue& name) {
  const EffectSpec* effect = FindEffect(ReadName(name));
  if (effect == nullptr || effect->name != ReadName(name)) {
    name.Fail("unknown effect '" + ReadName(name) + "'; did you mean '" +
              NearestName(ReadName(name), EffectNames()) + "'?");
  }
  return *effect;
}

/// Reads the scanner of an effect of the lidar.
std::string ReadEffectScanner(const YamlValue& value, const EffectSpec& spec,
                              const Scenario& scenario) {
  if (!value) return {};
  if (spec.sensor != EffectSensor::kLidar) value.Fail("is for effects of the lidar");
  std::vector<std::string> names{scenario.lidar.name};
  for (const LidarScenario& lidar : scenario.more_scanners) names.push_back(lidar.name);
  std::string name = ReadName(value);
  if (!HasName(names, name)) value.Fail("no scanner under lidar has the name '" + name + "'");
  return name;
}

Effect ReadEffect(const YamlValue& item, const Scenario& scenario) {
  item.ExpectMap({"effect", "scanner", "value", "window_s", "t0_s"});
  const EffectSpec& spec = RequireEffect(item["effect"]);
  Effect effect;
  effect.name = spec.name;
  effect.where = item.where();
  effect.scanner = ReadEffectScanner(item["scanner"], spec, scenario);
  if (item["value"]) effect.value = ReadNumberList(item["value"]);
  if (const auto fault = ValueFault(spec, effect.value)) item["value"].Fail(*fault);
  effect.times = ReadEffectTimes(item, spec);
  return effect;
}

}  // namespace

Scenario ParseScenario(const std::string& yaml_text, const std::string& where) {
  const YamlValue root = ParseYaml(yaml_text, where);
  root.ExpectMap({"name", "origin_deg_m", "start_s", "plan", "terrain", "imu", "gnss", "lidar",
                  "pairs", "control", "strips", "effects"});
  Scenario scenario;
  scenario.name = ReadName(root["name"]);
  scenario.origin = ReadOrigin(root["origin_deg_m"]);
  scenario.start_s = ReadNotNegativeOr(root["start_s"], 0.0);
  if (scenario.start_s >= kSecondsPerWeek) root["start_s"].Fail("must be less than a week");
  scenario.plan = ReadPlan(root["plan"], where);
  scenario.strips = ReadBoolOr(root["strips"], false);
  scenario.terrain = ReadTerrain(root["terrain"], scenario.strips);
  scenario.imu = ReadImuScenario(root["imu"]);
  scenario.gnss = ReadGnssScenario(root["gnss"]);
  scenario.lidar = ReadScanners(root["lidar"], HasScene(scenario.terrain), &scenario.more_scanners);
  scenario.pairs =
      ReadPairScenario(root["pairs"], scenario.lidar.gsd_m, !scenario.more_scanners.empty());
  scenario.control = ReadControlScenario(root["control"]);
  if (root["effects"]) {
    for (const YamlValue& item : root["effects"].List(kMostEffects)) {
      scenario.effects.push_back(ReadEffect(item, scenario));
    }
  }
  CheckLimits(scenario, [&](const std::string& section, const std::string& key) {
    return root[section][key].where();
  });
  return scenario;
}

}  // namespace dn
