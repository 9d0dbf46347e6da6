#include <dn/names.h>

#include <algorithm>

#include "config_sections.h"

namespace dn {
namespace internal {
namespace {

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

void CheckUnknown(const YamlValue& value, const std::string& name) {
  std::vector<std::string> estimable = EstimableUnknowns();
  estimable.insert(estimable.begin(), "boresight");
  if (Contains(estimable, name)) return;
  if (Contains(EffectNames(), name)) {
    value.Fail("'" + name + "' is an effect, but not estimable by this version; estimable are " +
               JoinNames(estimable));
  }
  std::vector<std::string> known = EffectNames();
  known.push_back("boresight");
  value.Fail("unknown name '" + name + "'; did you mean '" + NearestName(name, known) +
             "'? Estimable are " + JoinNames(estimable));
}

EstimateEntry ReadEntry(const YamlValue& item) {
  EstimateEntry entry;
  if (!item.IsMap()) {
    entry.unknown = item.Name();
    CheckUnknown(item, entry.unknown);
    return entry;
  }
  item.ExpectMap({"unknown", "sigma"});
  entry.unknown = item["unknown"].Name();
  CheckUnknown(item["unknown"], entry.unknown);
  if (!item["sigma"]) return entry;
  if (entry.unknown == "boresight") {
    item["sigma"].Fail("the prior of the boresight is lidar.boresight_sigma_deg");
  }
  entry.sigma = item["sigma"].Positive();
  return entry;
}

}  // namespace

const std::vector<std::string>& EffectNames() {
  static const std::vector<std::string> names{
      "gnss_lever_arm",     "gnss_time_offset",    "gnss_correlated_noise",
      "gnss_position_step", "gnss_noise_scale",    "gyro_scale_factor",
      "accel_scale_factor", "gyro_misalignment",   "accel_misalignment",
      "gyro_g_sensitivity", "gyro_bias_process",   "accel_bias_process",
      "gyro_noise_scale",   "accel_noise_scale",   "imu_vibration",
      "gravity_tilt",       "gravity_disturbance", "lidar_lever_arm",
      "lidar_time_offset",  "lidar_time_drift",    "lidar_range_offset",
      "lidar_range_scale",  "lidar_angle_scale",   "lidar_scan_cone",
      "boresight_drift",    "boresight_step",      "p2p_noise_scale",
      "p2p_outliers",       "p2p_range_noise",     "trajectory_attitude_offset"};
  return names;
}

std::vector<EstimateEntry> ReadEstimate(const YamlValue& section) {
  std::vector<EstimateEntry> entries;
  for (const YamlValue& item : section.Items()) {
    EstimateEntry entry = ReadEntry(item);
    const auto same = [&](const EstimateEntry& e) { return e.unknown == entry.unknown; };
    if (std::any_of(entries.begin(), entries.end(), same)) {
      item.Fail("'" + entry.unknown + "' is given twice");
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace internal

std::vector<std::string> EstimableUnknowns() {
  return {"gnss_lever_arm", "lidar_lever_arm", "lidar_time_offset", "gyro_scale_factor"};
}

}  // namespace dn
