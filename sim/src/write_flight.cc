#include <dn/geo/text_table.h>
#include <dn/sim/simulate.h>

#include <array>
#include <charconv>
#include <initializer_list>
#include <string>
#include <vector>

#include "imu_simulation.h"

namespace dn {
namespace {

/// Writes numbers separated by commas, each with as few digits as are needed to read back the same
/// bits.
class TableText {
 public:
  void Add(double value) {
    std::array<char, 32> buffer;
    const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
    if (!at_row_start_) text_ += ',';
    text_.append(buffer.data(), end);
    at_row_start_ = false;
  }
  void Add(const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) Add(v[i]);
  }
  void EndRow() {
    text_ += '\n';
    at_row_start_ = true;
  }
  void Reserve(std::size_t bytes) { text_.reserve(bytes); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  bool at_row_start_ = true;
};

std::string ImuText(const std::vector<ImuRow>& rows) {
  constexpr std::size_t kBytesPerRow = 150;
  TableText table;
  table.Reserve(kBytesPerRow * rows.size());
  for (const ImuRow& row : rows) {
    table.Add(row.t_s);
    table.Add(row.w_ib_b_radps);
    table.Add(row.f_b_mps2);
    table.EndRow();
  }
  return table.text();
}

std::string GnssText(const MapGnss& gnss, const LocalFrame& frame) {
  const bool velocity = !gnss.epochs.empty() && gnss.epochs.front().velocity_enu_mps.has_value();
  TableText table;
  for (const MapGnssEpoch& epoch : gnss.epochs) {
    table.Add(epoch.t_s);
    const Geodetic antenna = frame.ToGeodetic(epoch.p_m);
    table.Add(kDegPerRad * antenna.lat_rad);
    table.Add(kDegPerRad * antenna.lon_rad);
    table.Add(antenna.h_m);
    table.Add(Eigen::Vector3d(epoch.covariance_enu_m2->diagonal().cwiseSqrt()));
    if (velocity) {
      table.Add(*epoch.velocity_enu_mps);
      table.Add(Eigen::Vector3d(epoch.velocity_covariance_enu->diagonal().cwiseSqrt()));
    }
    table.EndRow();
  }
  return table.text();
}

std::string YamlList(const double* values, std::size_t count) {
  std::string text = "[";
  for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : ", ") + FormatDouble(values[i]);
  return text + "]";
}

std::string YamlList(const Eigen::Vector3d& v) { return YamlList(v.data(), 3); }

/// Returns a YAML double-quoted scalar.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string PairText(const PairData& data, int file) {
  std::vector<LidarPair> pairs;
  for (const LidarPair& pair : data.pairs) {
    if (pair.file == file) pairs.push_back(pair);
  }
  return FormatPairs(pairs);
}

/// Returns the text of a control file with the observations or the checks; empty without any.
std::string ControlText(const Flight& flight, bool checks) {
  std::string text;
  for (const ControlPoint& point : flight.control->points) {
    if (point.is_check != checks) continue;
    const Geodetic at = flight.frame.ToGeodetic(point.p_m);
    const Eigen::Vector3d sigma_m = point.covariance_m2.diagonal().cwiseSqrt();
    text += point.name;
    const auto add = [&](std::initializer_list<double> values) {
      for (const double value : values) text += ", " + FormatDouble(value);
    };
    add({kDegPerRad * at.lat_rad, kDegPerRad * at.lon_rad, at.h_m, sigma_m.x(), sigma_m.y(),
         sigma_m.z()});
    if (point.is_corner) {
      text += ", -, -, -, -, corner\n";
      continue;
    }
    const ControlReturn& one = point.returns.front();
    add({one.t_s, one.u_s.x(), one.u_s.y(), one.u_s.z()});
    text += ", surface\n";
  }
  if (text.empty()) return text;
  return "name, lat, lon, height, sigma_e, sigma_n, sigma_h, t, ux, uy, uz, shape\n" + text;
}

/// Returns the errors of the beams of a scanner; empty for a scanner with one beam.
std::string BeamsText(const BeamScenario& beams) {
  if (beams.count() == 0) return "";
  std::vector<double> angle_deg = beams.angle_error_rad;
  for (double& error : angle_deg) error *= kDegPerRad;
  return "beams: {angle_error_deg: " + YamlList(angle_deg.data(), angle_deg.size()) +
         ", range_error_m: " + YamlList(beams.range_error_m.data(), beams.range_error_m.size()) +
         "}";
}

/// Returns the true mountings of the scanners of a list; empty without a list.
std::string ScannersText(const SimulatedFlight& simulated) {
  const Scenario& scenario = simulated.scenario;
  if (scenario.lidar.name.empty()) return "";
  const auto line = [](const LidarScenario& lidar, const Eigen::Vector3d& boresight_rad,
                       const Eigen::Vector3d& lever_arm_m) {
    const std::string beams = BeamsText(lidar.beams);
    return "  - {name: " + Quoted(lidar.name) +
           ", boresight_deg: " + YamlList(kDegPerRad * boresight_rad) +
           ", lidar_lever_arm_m: " + YamlList(lever_arm_m) + (beams.empty() ? "" : ", ") + beams +
           "}\n";
  };
  std::string text =
      "scanners:\n" + line(scenario.lidar, simulated.boresight_rad, simulated.lidar_lever_arm_b_m);
  for (std::size_t k = 0; k < scenario.more_scanners.size(); ++k) {
    text += line(scenario.more_scanners[k], simulated.more_boresights_rad[k],
                 simulated.more_lever_arms_b_m[k]);
  }
  return text;
}

}  // namespace

std::string FormatTruth(const SimulatedFlight& simulated) {
  std::string text = "scenario: " + Quoted(simulated.scenario.name) + "\n";
  text += "seed: " + std::to_string(simulated.seed) + "\n";
  text += "boresight_deg: " + YamlList(kDegPerRad * simulated.boresight_rad) + "\n";
  text += "gnss_lever_arm_m: " + YamlList(simulated.gnss_lever_arm_b_m) + "\n";
  text += "lidar_lever_arm_m: " + YamlList(simulated.lidar_lever_arm_b_m) + "\n";
  text += ScannersText(simulated);
  if (simulated.scenario.lidar.name.empty() && simulated.scenario.lidar.beams.count() > 0) {
    text += BeamsText(simulated.scenario.lidar.beams) + "\n";
  }
  text += "effects:";
  if (simulated.scenario.effects.empty()) return text + " []\n";
  for (const Effect& effect : simulated.scenario.effects) {
    text += "\n  - {effect: " + effect.name;
    if (!effect.scanner.empty()) text += ", scanner: " + Quoted(effect.scanner);
    if (effect.value.size() == 1) text += ", value: " + FormatDouble(effect.value.front());
    if (effect.value.size() > 1) {
      text += ", value: " + YamlList(effect.value.data(), effect.value.size());
    }
    text += FormatEffectTimes(effect.times);
    text += "}";
  }
  return text + "\n";
}

void WriteMeasurements(const SimulatedFlight& simulated, OutputDirectory& directory) {
  const Flight& flight = simulated.flight;
  directory.Add("flight.yaml", FormatFlightConfig(flight.config));
  directory.Add("IMU.txt",
                ImuText(simulated.imu_rows.empty() ? ImuRows(*flight.imu) : simulated.imu_rows));
  directory.Add("GPS.txt", GnssText(*flight.gnss, flight.frame));
  if (flight.pairs) {
    for (std::size_t i = 0; i < flight.pairs->files.size(); ++i) {
      directory.Add(flight.pairs->files[i].generic_string(),
                    PairText(*flight.pairs, static_cast<int>(i)));
    }
  }
  if (flight.control) {
    for (const bool checks : {false, true}) {
      const std::string text = ControlText(flight, checks);
      if (!text.empty()) directory.Add(checks ? "control/checks.txt" : "control/points.txt", text);
    }
  }
  if (flight.trajectory) directory.Add("trajectory.out", FormatSbet(flight.trajectory->points()));
}

void WriteFlight(const SimulatedFlight& simulated, OutputDirectory& directory) {
  WriteMeasurements(simulated, directory);
  directory.Add("reference.out", FormatSbet(simulated.flight.reference->points()));
  directory.Add("truth.yaml", FormatTruth(simulated));
}

std::vector<CloudCounts> WriteClouds(
    const SimulatedFlight& simulated, int threads, OutputDirectory& directory,
    const std::function<void(const StripInterval& strip, double fraction)>& progress) {
  std::vector<CloudCounts> counts;
  const auto write = [&](const SimulatedClouds& clouds, const std::string& scanner) {
    const std::string folder = scanner.empty() ? "strips/" : "strips_" + scanner + "/";
    for (std::size_t k = 0; k < clouds.strips().size(); ++k) {
      const StripInterval& strip = clouds.strips()[k];
      counts.push_back(clouds.Write(k, directory.Stage(folder + strip.name + ".las"), threads,
                                    [&](double fraction) {
                                      if (progress) progress(strip, fraction);
                                    }));
    }
  };
  if (simulated.clouds) write(*simulated.clouds, simulated.scenario.lidar.name);
  for (std::size_t k = 0; k < simulated.more_clouds.size(); ++k) {
    write(*simulated.more_clouds[k], simulated.scenario.more_scanners[k].name);
  }
  return counts;
}

}  // namespace dn
