#include <dn/files/scanners.h>
#include <dn/geo/text_table.h>

#include "config_sections.h"

namespace dn {
namespace {

using files_internal::FindWord;

double Same(double value) { return value; }

std::string Number(double value, ToSi to_si = &Same) { return FormatDouble(InUnit(value, to_si)); }

std::string Number(const std::optional<double>& value) { return value ? Number(*value) : "~"; }

std::string List(const Eigen::VectorXd& values, ToSi to_si = &Same) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (i > 0) text += ", ";
    text += Number(values[i], to_si);
  }
  return text + "]";
}

std::string Matrix(const Eigen::Matrix3d& M) {
  return "[" + List(M.row(0)) + ", " + List(M.row(1)) + ", " + List(M.row(2)) + "]";
}

std::string Boolean(bool value) { return value ? "true" : "false"; }

/// Writes lines of YAML, indented by two blanks per level.
class Writer {
 public:
  void Line(int level, const std::string& text) {
    text_.append(2 * static_cast<std::size_t>(level), ' ');
    text_ += text;
    text_ += '\n';
  }
  void Key(int level, const std::string& key, const std::string& value) {
    Line(level, key + ": " + value);
  }
  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

void WriteColumns(const ColumnNames& names, Writer& out) {
  if (!names.empty()) out.Key(1, "columns", FormatColumnNames(names));
}

void WriteStrips(const std::vector<StripInterval>& strips, Writer& out) {
  if (strips.empty()) return out.Key(0, "strips", "~");
  out.Line(0, "strips:");
  for (const StripInterval& strip : strips) {
    out.Line(1, "- " + FormatStrip(strip));
  }
}

std::string Process(const BiasProcess& process, const files_internal::ProcessKeys& keys) {
  const bool walk = process.type == BiasProcess::Type::kRandomWalk;
  std::string text = "{type: " + FindWord(process.type, files_internal::ProcessWords()) + ", " +
                     (walk ? keys.walk : keys.sigma) + ": " +
                     Number(process.sigma, walk ? keys.walk_to_si : keys.sigma_to_si);
  if (process.type == BiasProcess::Type::kGaussMarkov) {
    text += ", tau_s: " + Number(process.tau_s);
  }
  return text + "}";
}

void WriteSensor(const char* name, const SensorNoise& noise,
                 const files_internal::ProcessKeys& keys, Writer& out) {
  out.Line(1, std::string(name) + ":");
  out.Key(2, keys.white, Number(noise.white, keys.white_to_si));
  if (noise.processes.empty()) return out.Key(2, "processes", "[]");
  out.Line(2, "processes:");
  for (const BiasProcess& process : noise.processes) {
    out.Line(3, "- " + Process(process, keys));
  }
}

std::string Noise(const SensorNoise& noise, const files_internal::ProcessKeys& keys) {
  std::string processes;
  for (const BiasProcess& process : noise.processes) {
    processes += (processes.empty() ? "" : ", ") + Process(process, keys);
  }
  return "{" + std::string(keys.white) + ": " + Number(noise.white, keys.white_to_si) +
         ", processes: [" + processes + "]}";
}

void WriteVibration(const std::vector<ImuVibration>& vibration, Writer& out) {
  if (vibration.empty()) return out.Key(1, "vibration", "[]");
  out.Line(1, "vibration:");
  for (const ImuVibration& v : vibration) {
    out.Line(2, "- {window_s: [" + Number(v.t0_s) + ", " + Number(v.t1_s) +
                    "], sigma_gyro_deg_s: " + Number(v.gyro_sigma_radps, &RadFromDeg) +
                    ", sigma_accel_m_s2: " + Number(v.accel_sigma_mps2) + "}");
  }
}

/// Returns the word of a unit, else its size.
std::string UnitText(double unit, const files_internal::Words<double>& words) {
  for (const auto& [word, value] : words) {
    if (value == unit) return word;
  }
  return Number(unit);
}

void WriteImu(const ImuConfig& imu, Writer& out) {
  out.Line(0, "imu:");
  out.Key(1, "file", QuoteYaml(imu.file));
  out.Key(1, "format", FindWord(imu.read.format, files_internal::ImuFormatWords()));
  WriteColumns(imu.read.columns, out);
  out.Key(1, "sampling", FindWord(imu.read.sampling, files_internal::ImuSamplingWords()));
  out.Key(1, "rate_unit", UnitText(imu.read.rate_unit_radps, files_internal::RateUnitWords()));
  out.Key(1, "force_unit", UnitText(imu.read.force_unit_mps2, files_internal::ForceUnitWords()));
  out.Key(1, "R_imu_to_body", Matrix(imu.read.R_imu_to_body));
  out.Key(1, "time_offset_s", Number(imu.read.time_offset_s));
  out.Key(1, "max_gap_s", Number(imu.read.max_gap_s));
  out.Key(1, "grade", imu.grade ? QuoteYaml(*imu.grade) : "~");
  WriteSensor("gyro", imu.model.gyro, files_internal::GyroKeys(), out);
  WriteSensor("accel", imu.model.accel, files_internal::AccelKeys(), out);
  WriteVibration(imu.model.vibration, out);
}

void WriteGnssProcesses(const GnssConfig& gnss, Writer& out) {
  if (gnss.processes.empty()) {
    return out.Key(1, "processes", gnss.automatic_process ? "auto" : "[]");
  }
  out.Line(1, "processes:");
  for (const GnssProcess& process : gnss.processes) out.Line(2, "- " + FormatGnssProcess(process));
}

void WriteGnss(const GnssConfig& gnss, Writer& out) {
  out.Line(0, "gnss:");
  out.Key(1, "file", QuoteYaml(gnss.file));
  out.Key(1, "format", FindWord(gnss.format, files_internal::GnssFormatWords()));
  WriteColumns(gnss.columns, out);
  if (gnss.only_changed) out.Key(1, "rows", "changed");
  out.Key(1, "time_offset_s", Number(gnss.time_offset_s));
  out.Key(1, "crs", gnss.crs);
  out.Key(1, "north", FindWord(gnss.grid_north, files_internal::NorthWords()));
  out.Key(1, "lever_arm_m", List(gnss.lever_arm_b_m));
  out.Key(1, "sigma_enu_m", List(gnss.sigma_enu_m));
  out.Key(1, "sigma_scale", Number(gnss.sigma_scale));
  out.Key(1, "velocity_sigma_scale", Number(gnss.velocity_sigma_scale));
  out.Key(1, "use_velocity", gnss.use_velocity ? Boolean(*gnss.use_velocity) : "auto");
  WriteGnssProcesses(gnss, out);
  out.Key(1, "robust", FindWord(gnss.robust, files_internal::RobustWords()));
}

std::string Selection(const PairSelection& selection) {
  return "{strategy: " + FindWord(selection.strategy, files_internal::StrategyWords()) +
         ", count: " + (selection.count ? std::to_string(*selection.count) : "~") +
         ", freq_hz: " + Number(selection.freq_hz) + ", window_s: " + Number(selection.window_s) +
         ", seed: " + std::to_string(selection.seed) + "}";
}

std::string NameList(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + QuoteYaml(name);
  return "[" + text + "]";
}

std::string BeamsText(const BeamConfig& beams) {
  std::string text = "{";
  if (beams.angles_rad.empty()) text += "count: " + std::to_string(beams.count);
  for (const double angle_rad : beams.angles_rad) {
    text += (text == "{" ? "angles_deg: [" : ", ") + Number(angle_rad, &RadFromDeg);
  }
  return text + (beams.angles_rad.empty() ? "" : "]") +
         ", angle_sigma_deg: " + Number(beams.angle_sigma_rad, &RadFromDeg) +
         ", range_offset_sigma_m: " + Number(beams.range_sigma_m) + "}";
}

/// Writes the keys of a scanner at a level.
void WriteScanner(const LidarConfig& lidar, int level, Writer& out) {
  out.Key(level, "p2p", NameList(lidar.p2p));
  if (!lidar.surface_pairs.empty()) out.Key(level, "surface_pairs", NameList(lidar.surface_pairs));
  out.Key(level, "time_offset_s", Number(lidar.time_offset_s));
  out.Key(level, "pairs", Selection(lidar.pairs));
  out.Key(level, "R_sensor_to_body", Matrix(lidar.mounting.R_bs_nominal));
  out.Key(level, "lever_arm_m", List(lidar.mounting.lever_arm_b_m));
  out.Key(level, "boresight_deg", List(lidar.mounting.boresight_rad, &RadFromDeg));
  out.Key(level, "boresight_sigma_deg",
          lidar.boresight_sigma_rad ? List(*lidar.boresight_sigma_rad, &RadFromDeg) : "~");
  out.Key(level, "georeferenced_with",
          lidar.georeferenced_with_rad
              ? "{boresight_deg: " + List(*lidar.georeferenced_with_rad, &RadFromDeg) + "}"
              : "~");
  out.Key(level, "scan_axis", List(lidar.scan_axis_s));
  out.Key(level, "nadir_axis", List(lidar.nadir_axis_s));
  out.Key(level, "gsd_m", Number(lidar.gsd_m));
  out.Key(level, "sigma_p_m", Number(lidar.sigma_p_m));
  out.Key(level, "robust", FindWord(lidar.robust, files_internal::RobustWords()));
  if (lidar.beams) out.Key(level, "beams", BeamsText(*lidar.beams));
}

void WriteLidar(const FlightConfig& config, Writer& out) {
  out.Line(0, "lidar:");
  if (config.lidar->name.empty()) return WriteScanner(*config.lidar, 1, out);
  for (std::size_t k = 0; k < NumScanners(config); ++k) {
    out.Line(1, "- name: " + QuoteYaml(ScannerAt(config, k).name));
    WriteScanner(ScannerAt(config, k), 2, out);
  }
}

void WritePairsBetween(const FlightConfig& config, Writer& out) {
  if (config.pairs_between.empty()) return;
  out.Line(0, "pairs_between:");
  for (const PairsBetween& between : config.pairs_between) {
    out.Line(1, "- {scanners: " +
                    NameList({ScannerAt(config, between.scanner_i).name,
                              ScannerAt(config, between.scanner_j).name}) +
                    ", p2p: " + NameList(between.p2p) +
                    ", sigma_p_m: " + Number(between.sigma_p_m) + "}");
  }
}

void WriteTies(const std::vector<TieFiles>& ties, Writer& out) {
  if (ties.empty()) return;
  out.Line(0, "ties:");
  for (const TieFiles& files : ties) {
    out.Line(1, "- {p2p: " + NameList(files.p2p) +
                    ", end: " + FindWord(files.second, files_internal::EndWords()) +
                    ", count: " + std::to_string(files.count) + "}");
  }
}

void WriteTrajectory(const TrajectoryConfig& trajectory, Writer& out) {
  out.Line(0, "trajectory:");
  out.Key(1, "file", QuoteYaml(trajectory.file));
  const TrajectoryColumns& columns = trajectory.columns;
  WriteColumns(columns.names, out);
  out.Key(1, "crs", QuoteYaml(columns.crs));
  out.Key(1, "attitude", FindWord(columns.attitude, files_internal::AttitudeWords()));
  out.Key(1, "north", FindWord(columns.grid_north, files_internal::NorthWords()));
  out.Key(1, "sigma_xy_m", Number(trajectory.sigma_xy_m));
  out.Key(1, "sigma_z_m", Number(trajectory.sigma_z_m));
  out.Key(1, "sigma_rp_deg", Number(trajectory.sigma_rp_rad, &RadFromDeg));
  out.Key(1, "sigma_y_deg", Number(trajectory.sigma_y_rad, &RadFromDeg));
  out.Key(1, "sigma_file", trajectory.sigma_file.empty() ? "~" : QuoteYaml(trajectory.sigma_file));
}

void WriteControl(const ControlConfig& control, Writer& out) {
  const auto sigmas = [](const std::optional<Eigen::Vector3d>& sigma_m) {
    return sigma_m ? List(*sigma_m) : "~";
  };
  out.Line(0, "control:");
  out.Key(1, "files", NameList(control.files));
  out.Key(1, "crs", control.crs.empty() ? "~" : QuoteYaml(control.crs));
  out.Key(1, "sigma_enu_m", sigmas(control.sigma_enu_m));
  out.Key(1, "laser_sigma_m", Number(control.laser_sigma_m));
  out.Key(1, "datum_shift_sigma_m", sigmas(control.datum_shift_sigma_m));
  out.Key(1, "checks", NameList(control.checks));
  out.Key(1, "search_radius_m", Number(control.search_radius_m));
  out.Key(1, "corner_radius_m", Number(control.corner_radius_m));
}

std::string Estimate(const EstimateEntry& entry) {
  const std::vector<double>& sigma = entry.sigma;
  std::string more = FormatEffectTimes(entry.times);
  const std::string unknown = entry.unknown.substr(0, entry.unknown.find('/'));
  if (!entry.scanner.empty()) more = ", scanner: " + QuoteYaml(entry.scanner) + more;
  if (sigma.size() == 1) more += ", sigma: " + Number(sigma.front());
  if (sigma.size() > 1) {
    more += ", sigma: " + List(Eigen::Map<const Eigen::VectorXd>(
                              sigma.data(), static_cast<Eigen::Index>(sigma.size())));
  }
  return more.empty() ? unknown : "{unknown: " + unknown + more + "}";
}

void WriteEstimate(const std::vector<EstimateEntry>& entries, Writer& out) {
  std::string text;
  for (const EstimateEntry& entry : entries) {
    if (!text.empty()) text += ", ";
    text += Estimate(entry);
  }
  out.Key(0, "estimate", "[" + text + "]");
}

void WriteUnmodelled(const UnmodelledConfig& unmodelled, Writer& out) {
  if (unmodelled.none) {
    out.Key(0, "unmodelled", "none");
    return;
  }
  std::string text;
  for (const auto& [effect, sigma] : unmodelled.sizes) {
    if (!text.empty()) text += ", ";
    text += EffectName(effect) + ": ";
    text += sigma.size() == 1 ? Number(sigma.front())
                              : List(Eigen::Map<const Eigen::VectorXd>(
                                    sigma.data(), static_cast<Eigen::Index>(sigma.size())));
  }
  out.Key(0, "unmodelled", "{" + text + "}");
}

void WriteBegin(const FlightConfig& config, Writer& out) {
  if (config.body_is_flu) {
    out.Line(0,
             "# Resolved from 'body: FLU' to FRD; the data files remain FLU, text trajectories "
             "included.");
  }
  out.Key(0, "name", QuoteYaml(config.name));
  out.Key(0, "body", "FRD");
}

void WriteFileHeader(const FlightConfig& config, Writer& out) {
  out.Key(0, "name", QuoteYaml(config.name));
  out.Line(0, "# Folder of the data, used if they are not in the folder of this file.");
  const std::filesystem::path folder = std::filesystem::absolute(config.folder);
  out.Key(0, "data_folder", QuoteYaml(folder.lexically_normal().string()));
  out.Key(0, "body", FindWord(config.body_is_flu, files_internal::BodyWords()));
}

void WriteHead(const FlightConfig& config, Writer& out) {
  const std::optional<Geodetic>& o = config.origin;
  out.Key(0, "frame",
          o ? "{origin_deg_m: [" + Number(o->lat_rad, &RadFromDeg) + ", " +
                  Number(o->lon_rad, &RadFromDeg) + ", " + Number(o->h_m) + "]}"
            : "{origin_deg_m: ~}");
  out.Key(0, "time_span_s", config.time_span_s ? List(*config.time_span_s) : "~");
  if (!config.unexplained.empty()) out.Key(0, "unexplained", QuoteYaml(config.unexplained));
  WriteStrips(config.strips, out);
  out.Key(0, "strips_crs", QuoteYaml(config.strips_crs));
}

/// Returns the configuration with body quantities in forward-left-up.
FlightConfig WithBodyFlipped(FlightConfig config) {
  using files_internal::FlipBody;
  if (config.imu) FlipBody(&config.imu->read.R_imu_to_body);
  if (config.gnss) config.gnss->lever_arm_b_m = FlipBody(config.gnss->lever_arm_b_m);
  for (std::size_t k = 0; k < NumScanners(config); ++k) {
    LidarConfig& lidar = ScannerAt(config, k);
    Mounting& mounting = lidar.mounting;
    FlipBody(&mounting.R_bs_nominal);
    mounting.lever_arm_b_m = FlipBody(mounting.lever_arm_b_m);
    mounting.boresight_rad = FlipBody(mounting.boresight_rad);
    auto& georeferenced_with_rad = lidar.georeferenced_with_rad;
    if (georeferenced_with_rad) georeferenced_with_rad = FlipBody(*georeferenced_with_rad);
  }
  return config;
}

void WriteRest(const FlightConfig& config, Writer& out) {
  WriteHead(config, out);
  if (config.imu) WriteImu(*config.imu, out);
  if (config.gnss) WriteGnss(*config.gnss, out);
  if (config.lidar) WriteLidar(config, out);
  WritePairsBetween(config, out);
  if (config.trajectory) WriteTrajectory(*config.trajectory, out);
  if (config.control) WriteControl(*config.control, out);
  WriteTies(config.ties, out);
  out.Key(0, "gh",
          "{rotation: " + FindWord(config.gh.exponential, files_internal::GhRotationWords()) +
              ", libor_compat: " + Boolean(config.gh.libor_compat) + "}");
  WriteUnmodelled(config.unmodelled, out);
  WriteEstimate(config.estimate, out);
  out.Key(0, "network",
          "{inertial: " + FindWord(config.network.inertial, files_internal::InertialWords()) +
              ", node_rate_hz: " +
              (config.network.node_rate_hz ? Number(*config.network.node_rate_hz) : "auto") + "}");
}

}  // namespace

std::string QuoteYaml(const std::string& text) {
  static const char* const kHex = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (byte < 0x20) {
      quoted += {'\\', 'x', kHex[byte >> 4], kHex[byte & 15]};
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string FormatGnssProcess(const GnssProcess& process) {
  const bool grows = process.growth != GnssErrorGrowth::kNone;
  return "{type: gauss_markov, sigma_enu_m: " + List(process.sigma_enu_m) +
         ", tau_s: " + Number(process.tau_s) +
         (grows
              ? ", grows_with: " + FindWord(process.growth, files_internal::GnssErrorGrowthWords())
              : "") +
         "}";
}

std::string FormatGyroNoise(const SensorNoise& noise) {
  return Noise(noise, files_internal::GyroKeys());
}

std::string FormatAccelNoise(const SensorNoise& noise) {
  return Noise(noise, files_internal::AccelKeys());
}

std::string FormatStrip(const StripInterval& strip) {
  return "{name: " + QuoteYaml(strip.name) + ", t0: " + Number(strip.t0_s) +
         ", t1: " + Number(strip.t1_s) + "}";
}

std::string FormatFlightConfig(const FlightConfig& config) {
  Writer out;
  WriteBegin(config, out);
  WriteRest(config, out);
  return out.Take();
}

std::string FormatFlightFile(const FlightConfig& config) {
  Writer out;
  WriteFileHeader(config, out);
  WriteRest(config.body_is_flu ? WithBodyFlipped(config) : config, out);
  return out.Take();
}

}  // namespace dn
