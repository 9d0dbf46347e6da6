#include <dn/files/file_units.h>
#include <dn/files/yaml_sections.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>
#include <dn/sim/scenario.h>

#include "scenario_words.h"
#include "vibration_section.h"

namespace dn {
namespace {

double Same(double value) { return value; }
double FromDeg(double deg) { return deg * kRadPerDeg; }
double FromMilli(double milli) { return 1e-3 * milli; }

std::string Number(double value, ToSi to_si = &Same) { return FormatDouble(InUnit(value, to_si)); }

template <class Values>
std::string List(const Values& values, ToSi to_si = &Same) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + Number(value, to_si);
  return "[" + text + "]";
}

std::string Matrix(const Eigen::Matrix3d& M) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    text += (row == 0 ? "" : ", ") + List(Eigen::Vector3d(M.row(row)));
  }
  return "[" + text + "]";
}

template <class T>
std::string FindWord(T value, const ScenarioWords<T>& words) {
  for (const auto& [word, meaning] : words) {
    if (meaning == value) return word;
  }
  return {};
}

/// Collects lines of YAML; the lines of a section are indented.
class Writer {
 public:
  void Section(const std::string& name) { text_ += name + ":\n"; }
  void Top(const std::string& key, const std::string& value) { text_ += key + ": " + value + "\n"; }
  void Key(const std::string& key, const std::string& value) { Line(key + ": " + value); }
  void Line(const std::string& line) { text_ += "  " + line + "\n"; }
  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

std::string Turbulence(const TurbulenceScenario& t) {
  return "{roll_deg: " + Number(t.roll_rad, &FromDeg) +
         ", pitch_deg: " + Number(t.pitch_rad, &FromDeg) +
         ", heading_deg: " + Number(t.heading_rad, &FromDeg) +
         ", speed_m_s: " + Number(t.speed_mps) + ", height_m: " + Number(t.height_m) +
         ", spectrum: " + FindWord(t.spectrum, TurbulenceWords()) +
         (t.spectrum == TurbulenceSpectrum::kDryden ? ", wingspan_m: " + Number(t.wingspan_m)
                                                    : "") +
         "}";
}

std::string Row(const PlannedLine& line) {
  return List(std::vector<double>{line.start_en_m.x(), line.start_en_m.y(), line.end_en_m.x(),
                                  line.end_en_m.y(), line.height_m, line.speed_mps});
}

void WritePlan(const PlanScenario& plan, Writer* out) {
  out->Section("plan");
  out->Key("warm_up_s", Number(plan.warm_up_s));
  if (plan.replay) out->Key("replay", QuoteYaml(plan.replay->string()));
  if (!plan.strips.empty()) out->Line("strips:");
  for (const StripInterval& strip : plan.strips) out->Line("  - " + FormatStrip(strip));
  if (!plan.lines.empty()) out->Line("lines:");
  for (const PlannedLine& line : plan.lines) out->Line("  - " + Row(line));
  out->Key("bank_deg", Number(plan.bank_rad, &FromDeg));
  out->Key("turbulence", Turbulence(plan.turbulence));
  out->Key("crab_deg", Number(plan.crab_rad, &FromDeg));
  out->Key("vibration", FormatVibration(plan.vibration));
  out->Key("stabilised_mount", plan.stabilised_mount ? "true" : "false");
}

void WriteTerrain(const TerrainScenario& terrain, Writer* out) {
  out->Section("terrain");
  out->Key("kind", FindWord(terrain.kind, TerrainWords()));
  out->Key("base_m", Number(terrain.base_m));
  out->Key("relief_m", Number(terrain.relief_m));
  out->Key("wavelength_m", Number(terrain.wavelength_m));
  out->Key("buildings_per_km2", Number(terrain.buildings_per_km2));
  out->Key("trees_per_km2", Number(terrain.trees_per_km2));
  out->Key("roughness_m", Number(terrain.roughness_m));
  out->Key("water_share", Number(terrain.water_share));
  if (terrain.woods_share > 0.0) out->Key("woods_share", Number(terrain.woods_share));
  if (HasScene(terrain)) {
    out->Key("cars_per_km2", Number(terrain.cars_per_km2));
    out->Key("conifer_share", Number(terrain.conifer_share));
    out->Key("leaves", terrain.leaves ? "true" : "false");
  }
  out->Key("seed", std::to_string(terrain.seed));
}

void WriteImu(const ImuScenario& imu, Writer* out) {
  out->Section("imu");
  out->Key("rate_hz", Number(imu.rate_hz));
  out->Key("sampling", FindWord(imu.sampling, SamplingWords()));
  if (imu.filter_hz) out->Key("filter_hz", Number(*imu.filter_hz));
  if (imu.preset) return out->Key("preset", QuoteYaml(*imu.preset));
  out->Key("gyro", FormatGyroNoise(imu.model.gyro));
  out->Key("accel", FormatAccelNoise(imu.model.accel));
}

void WriteGnss(const GnssScenario& gnss, Writer* out) {
  out->Section("gnss");
  out->Key("rate_hz", Number(gnss.rate_hz));
  out->Key("sigma_enu_m", List(gnss.sigma_enu_m));
  out->Key("lever_arm_m", List(gnss.lever_arm_b_m));
  out->Key("velocity", gnss.velocity ? "true" : "false");
  std::string processes;
  for (const GnssProcess& process : gnss.processes) {
    processes += (processes.empty() ? "" : ", ") + FormatGnssProcess(process);
  }
  out->Key("processes", "[" + processes + "]");
}

std::string BeamsText(const BeamScenario& beams) {
  const auto list = [](const char* key, const std::vector<double>& values, auto... unit) {
    std::string text;
    for (const double value : values) text += (text.empty() ? "" : ", ") + Number(value, unit...);
    return ", " + std::string(key) + ": [" + text + "]";
  };
  std::string text = "{rotation_hz: " + Number(beams.rotation_hz) +
                     list("angles_deg", beams.angles_rad, &RadFromDeg) +
                     ", angle_sigma_deg: " + Number(beams.angle_sigma_rad, &RadFromDeg) +
                     ", range_offset_sigma_m: " + Number(beams.range_sigma_m);
  if (!beams.angle_error_rad.empty()) {
    text += list("angle_error_deg", beams.angle_error_rad, &FromDeg);
  }
  if (!beams.range_error_m.empty()) text += list("range_error_m", beams.range_error_m);
  return text + "}";
}

/// Writes the keys of a scanner; `indent` is for those of a list. detailed: true over a detailed
/// terrain.
void WriteScanner(const LidarScenario& lidar, const std::string& indent, bool detailed,
                  Writer* out) {
  out->Key(indent + "R_sensor_to_body", Matrix(lidar.mounting.R_bs_nominal));
  out->Key(indent + "scan_axis", List(lidar.scan_axis_s));
  out->Key(indent + "nadir_axis", List(lidar.nadir_axis_s));
  out->Key(indent + "lever_arm_m", List(lidar.mounting.lever_arm_b_m));
  out->Key(indent + "boresight_deg", List(lidar.mounting.boresight_rad, &FromDeg));
  out->Key(indent + "fov_deg", Number(lidar.fov_rad, &FromDeg));
  out->Key(indent + "pattern", FindWord(lidar.pattern, ScanPatternWords()));
  out->Key(indent + "gsd_m", Number(lidar.gsd_m));
  out->Key(indent + "pulse_rate_hz", Number(lidar.pulse_rate_hz));
  out->Key(indent + "beam_divergence_mrad", Number(lidar.beam_divergence_rad, &FromMilli));
  out->Key(indent + "sigma_range_m", Number(lidar.sigma_range_m));
  if (lidar.beams.count() > 0) out->Key(indent + "beams", BeamsText(lidar.beams));
  if (lidar.max_returns == 1 && lidar.scan_variation == 0.0 && !detailed) return;
  out->Key(indent + "max_returns", std::to_string(lidar.max_returns));
  out->Key(indent + "range_resolution_m", Number(lidar.range_resolution_m));
  out->Key(indent + "noise_share", Number(lidar.noise_share));
  out->Key(indent + "scan_variation", Number(lidar.scan_variation));
}

void WriteLidar(const Scenario& scenario, Writer* out) {
  const bool detailed = HasScene(scenario.terrain);
  out->Section("lidar");
  if (scenario.lidar.name.empty()) return WriteScanner(scenario.lidar, "", detailed, out);
  std::vector<LidarScenario> all{scenario.lidar};
  all.insert(all.end(), scenario.more_scanners.begin(), scenario.more_scanners.end());
  for (const LidarScenario& lidar : all) {
    out->Line("- name: " + QuoteYaml(lidar.name));
    WriteScanner(lidar, "  ", detailed, out);
  }
}

void WriteEffects(const std::vector<Effect>& effects, Writer* out) {
  if (effects.empty()) return out->Top("effects", "[]");
  out->Section("effects");
  for (const Effect& effect : effects) {
    std::string text = "- {effect: " + effect.name;
    if (!effect.scanner.empty()) text += ", scanner: " + QuoteYaml(effect.scanner);
    if (!effect.value.empty()) text += ", value: " + List(effect.value);
    out->Line(text + FormatEffectTimes(effect.times) + "}");
  }
}

std::string PairText(const PairScenario& pairs, bool several_scanners) {
  std::string text =
      "{count: " + std::to_string(pairs.count) + ", sigma_p_m: " + Number(pairs.sigma_p_m);
  if (several_scanners) text += ", between: " + std::to_string(pairs.between);
  if (pairs.shared_fraction > 0.0) {
    text += ", shared_error: {fraction: " + Number(pairs.shared_fraction) +
            ", length_m: " + Number(pairs.shared_length_m) + "}";
  }
  return text + "}";
}

std::string ControlText(const ControlScenario& control) {
  return "{points: " + std::to_string(control.points) +
         ", checks: " + std::to_string(control.checks) +
         ", corners: " + std::to_string(control.corners) +
         ", corner_checks: " + std::to_string(control.corner_checks) + ", sigma_m: [" +
         Number(control.sigma_enu_m.x()) + ", " + Number(control.sigma_enu_m.y()) + ", " +
         Number(control.sigma_enu_m.z()) + "]}";
}

}  // namespace

std::string FormatScenario(const Scenario& scenario) {
  Writer out;
  out.Top("name", QuoteYaml(scenario.name));
  const Geodetic& origin = scenario.origin;
  out.Top("origin_deg_m", "[" + Number(origin.lat_rad, &FromDeg) + ", " +
                              Number(origin.lon_rad, &FromDeg) + ", " + Number(origin.h_m) + "]");
  out.Top("start_s", Number(scenario.start_s));
  WritePlan(scenario.plan, &out);
  WriteTerrain(scenario.terrain, &out);
  WriteImu(scenario.imu, &out);
  WriteGnss(scenario.gnss, &out);
  WriteLidar(scenario, &out);
  out.Top("pairs", PairText(scenario.pairs, !scenario.more_scanners.empty()));
  if (!scenario.control.empty()) out.Top("control", ControlText(scenario.control));
  out.Top("strips", scenario.strips ? "true" : "false");
  WriteEffects(scenario.effects, &out);
  return out.Take();
}

}  // namespace dn
