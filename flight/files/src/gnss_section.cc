#include <cmath>

#include "config_sections.h"

namespace dn {
namespace {

Eigen::Vector3d ProcessSigmas(const YamlValue& value) {
  Eigen::Vector3d sigma = ReadVector3(value);
  if (sigma.minCoeff() < 0.0) value.Fail("no element may be negative");
  if (sigma.maxCoeff() < files_internal::kLeastSigmaM)
    value.Fail("one element must be at least 1e-12");
  return sigma;
}

GnssProcess ReadGnssProcess(const YamlValue& item) {
  item.ExpectMap({"type", "sigma_enu_m", "tau_s", "grows_with"});
  item["type"].Choice(files_internal::GnssProcessWords());
  GnssProcess process{ProcessSigmas(item["sigma_enu_m"]), ReadPositive(item["tau_s"])};
  if (item["grows_with"]) {
    process.growth = item["grows_with"].Choice(files_internal::GnssErrorGrowthWords());
  }
  return process;
}

/// Returns whether `processes` is absent or auto. A list, also an empty one, is not.
bool IsAutomatic(const YamlValue& processes) {
  if (!processes) return true;
  if (!processes.IsScalar()) return false;
  if (processes.Text() != "auto") processes.Fail("expected auto, or a list of processes");
  return true;
}

}  // namespace

std::vector<GnssProcess> ReadGnssProcesses(const YamlValue& section) {
  std::vector<GnssProcess> processes;
  if (!section["processes"]) return processes;
  for (const YamlValue& item : section["processes"].List(files_internal::kMostProcesses)) {
    processes.push_back(ReadGnssProcess(item));
  }
  return processes;
}

}  // namespace dn

namespace dn::files_internal {

double ReadTimeOffset(const YamlValue& section) {
  constexpr double kMostS = 4e9;
  const YamlValue value = section["time_offset_s"];
  const double offset_s = ReadNumberOr(value, 0.0);
  if (std::abs(offset_s) > kMostS) value.Fail("must lie within -4e9 and 4e9 s");
  return offset_s;
}

GnssConfig ReadGnssSection(const YamlValue& section, bool body_is_flu) {
  section.ExpectMap({"file", "format", "columns", "rows", "crs", "north", "time_offset_s",
                     "lever_arm_m", "sigma_enu_m", "sigma_scale", "velocity_sigma_scale",
                     "use_velocity", "processes", "robust"});
  GnssConfig gnss;
  if (section["file"]) gnss.file = section["file"].Text();
  if (section["format"]) gnss.format = section["format"].Choice(GnssFormatWords());
  if (section["crs"]) gnss.crs = ReadTextCrs(section["crs"]);
  if (section["north"]) gnss.grid_north = ReadNorth(section["north"], gnss.crs);
  const bool own = gnss.format == GnssFormat::kRtklib || gnss.format == GnssFormat::kNmea;
  if (own && gnss.crs != "geographic") {
    section["crs"].Fail("files of rtklib and nmea define their coordinates themselves; remove crs");
  }
  gnss.columns = ReadColumnNames(section, GnssQuantities());
  if (!gnss.columns.empty() && gnss.format != GnssFormat::kOdyn) {
    section["columns"].Fail("only files of format odyn have named columns; remove columns");
  }
  if (section["rows"]) {
    static const Words<bool> words{{"all", false}, {"changed", true}};
    gnss.only_changed = section["rows"].Choice(words);
    if (gnss.only_changed && gnss.columns.empty()) section["rows"].Fail("changed needs columns");
  }
  gnss.time_offset_s = ReadTimeOffset(section);
  if (section["lever_arm_m"]) {
    const Eigen::Vector3d lever_arm_m = ReadVector3(section["lever_arm_m"]);
    gnss.lever_arm_b_m = body_is_flu ? FlipBody(lever_arm_m) : lever_arm_m;
  }
  if (section["sigma_enu_m"]) gnss.sigma_enu_m = ReadPositiveVector3(section["sigma_enu_m"]);
  if (section["sigma_scale"]) gnss.sigma_scale = ReadPositive(section["sigma_scale"]);
  if (section["velocity_sigma_scale"]) {
    gnss.velocity_sigma_scale = ReadPositive(section["velocity_sigma_scale"]);
  }
  if (section["use_velocity"]) {
    static const Words<std::optional<bool>> words{
        {"auto", std::nullopt}, {"true", true}, {"false", false}};
    gnss.use_velocity = section["use_velocity"].Choice(words);
  }
  gnss.automatic_process = IsAutomatic(section["processes"]);
  if (!gnss.automatic_process) gnss.processes = ReadGnssProcesses(section);
  if (section["robust"]) gnss.robust = section["robust"].Choice(RobustWords());
  return gnss;
}

}  // namespace dn::files_internal
