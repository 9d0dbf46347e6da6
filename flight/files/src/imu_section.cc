#include <dn/error.h>
#include <dn/files/effect_times.h>
#include <dn/geo/text_fields.h>
#include <dn/imu/unknown_imu.h>
#include <dn/names.h>

#include <filesystem>

#include "config_sections.h"

namespace dn::files_internal {
namespace {

// This limit suffices for a list that is written by hand.
constexpr std::size_t kMostVibrations = 1000;

double ProcessSigma(const YamlValue& item, const char* key, ToSi to_si) {
  return to_si(ReadPositive(item[key]));
}

BiasProcess ReadProcess(const YamlValue& item, const ProcessKeys& keys) {
  item.ExpectMap({"type", keys.sigma, keys.walk, "tau_s"});
  BiasProcess process;
  process.type = item["type"].Choice(ProcessWords());
  switch (process.type) {
    case BiasProcess::Type::kRandomConstant:
      item.ExpectMap({"type", keys.sigma});
      process.sigma = ProcessSigma(item, keys.sigma, keys.sigma_to_si);
      break;
    case BiasProcess::Type::kGaussMarkov:
      item.ExpectMap({"type", keys.sigma, "tau_s"});
      process.sigma = ProcessSigma(item, keys.sigma, keys.sigma_to_si);
      process.tau_s = ReadPositive(item["tau_s"]);
      break;
    case BiasProcess::Type::kRandomWalk:
      item.ExpectMap({"type", keys.walk});
      process.sigma = ProcessSigma(item, keys.walk, keys.walk_to_si);
      break;
  }
  return process;
}

/// Overrides the preset with the values of the section. The white noise must come from one of them.
void ReadSensor(const YamlValue& section, const ProcessKeys& keys, const YamlValue& preset,
                SensorNoise& noise) {
  if (section) {
    section.ExpectMap({keys.white, "processes"});
    if (section[keys.white]) noise.white = keys.white_to_si(ReadPositive(section[keys.white]));
    if (section["processes"]) {
      noise.processes.clear();
      for (const YamlValue& item : section["processes"].List(kMostProcesses)) {
        noise.processes.push_back(ReadProcess(item, keys));
      }
    }
  }
  if (!preset && noise.white == 0.0) {
    const YamlValue place = section ? section[keys.white] : section;
    place.Fail(std::string("the white noise is missing: give ") + keys.white +
               ", or name a preset with " + preset.path() + " (" + JoinNames(ImuPresetNames()) +
               ")");
  }
}

bool SameNoise(const SensorNoise& a, const SensorNoise& b) {
  if (a.white != b.white || a.processes.size() != b.processes.size()) return false;
  for (std::size_t i = 0; i < a.processes.size(); ++i) {
    const BiasProcess& p = a.processes[i];
    const BiasProcess& q = b.processes[i];
    if (p.type != q.type || p.sigma != q.sigma || p.tau_s != q.tau_s) return false;
  }
  return true;
}

/// Reads a word, or the size of one unit as a number.
double ReadUnit(const YamlValue& value, const Words<double>& words) {
  return FieldNumber(value.Text()) ? ReadPositive(value) : value.Choice(words);
}

ImuVibration ReadVibration(const YamlValue& item) {
  item.ExpectMap({"window_s", "sigma_gyro_deg_s", "sigma_accel_m_s2"});
  if (!item["window_s"]) item["window_s"].Fail("is missing");
  const auto [t0_s, t1_s] = ReadWindow(item["window_s"]);
  const ImuVibration vibration{t0_s, t1_s,
                               RadFromDeg(ReadNotNegativeOr(item["sigma_gyro_deg_s"], 0.0)),
                               ReadNotNegativeOr(item["sigma_accel_m_s2"], 0.0)};
  if (vibration.gyro_sigma_radps == 0.0 && vibration.accel_sigma_mps2 == 0.0) {
    item.Fail("sigma_gyro_deg_s and sigma_accel_m_s2 are both 0, one must be positive");
  }
  return vibration;
}

}  // namespace

const ProcessKeys& GyroKeys() {
  static const ProcessKeys keys{"sigma_deg_h",        &RadpsFromDegPerHour,
                                "sigma_deg_h_sqrt_h", &RadpsPerSqrtSFromDegPerHourPerSqrtHour,
                                "white_deg_sqrt_h",   &RadPerSqrtSFromDegPerSqrtHour};
  return keys;
}

const ProcessKeys& AccelKeys() {
  static const ProcessKeys keys{"sigma_mg",         &Mps2FromMg,
                                "sigma_mg_sqrt_h",  &Mps2PerSqrtSFromMgPerSqrtHour,
                                "white_m_s_sqrt_h", &MpsPerSqrtSFromMpsPerSqrtHour};
  return keys;
}

ImuConfig ReadImuSection(const YamlValue& section, bool body_is_flu) {
  section.ExpectMap({"file", "format", "columns", "sampling", "rate_unit", "force_unit",
                     "R_imu_to_body", "time_offset_s", "max_gap_s", "grade", "gyro", "accel",
                     "vibration"});
  ImuConfig imu;
  if (section["file"]) imu.file = section["file"].Text();
  if (section["format"]) imu.read.format = section["format"].Choice(ImuFormatWords());
  imu.read.columns = ReadColumnNames(section, ImuQuantities());
  if (section["sampling"]) imu.read.sampling = section["sampling"].Choice(ImuSamplingWords());
  if (section["rate_unit"]) {
    imu.read.rate_unit_radps = ReadUnit(section["rate_unit"], RateUnitWords());
  }
  if (section["force_unit"]) {
    imu.read.force_unit_mps2 = ReadUnit(section["force_unit"], ForceUnitWords());
  }
  if (section["R_imu_to_body"]) imu.read.R_imu_to_body = ReadRotation(section["R_imu_to_body"]);
  if (body_is_flu) FlipBody(&imu.read.R_imu_to_body);
  imu.read.time_offset_s = ReadTimeOffset(section);
  if (section["max_gap_s"]) imu.read.max_gap_s = ReadPositive(section["max_gap_s"]);
  if (section["grade"]) imu.grade = ReadName(section["grade"]);
  imu.model = ReadImuNoise(section, "grade");
  if (section["vibration"]) {
    for (const YamlValue& item : section["vibration"].List(kMostVibrations)) {
      imu.model.vibration.push_back(ReadVibration(item));
    }
  }
  return imu;
}

}  // namespace dn::files_internal

namespace dn {

ImuModel ReadImuNoise(const YamlValue& section, const std::string& preset_key) {
  const YamlValue named = section[preset_key];
  ImuModel preset;
  if (named) {
    const std::string name = ReadName(named);
    try {
      const bool unknown = preset_key == "grade" && name == kUnknownGrade;
      preset = unknown ? UnknownImu() : ImuPreset(name);
    } catch (const InvalidConfig& e) {
      named.Fail(e.what());
    }
  }
  ImuModel model = preset;
  files_internal::ReadSensor(section["gyro"], files_internal::GyroKeys(), named, model.gyro);
  files_internal::ReadSensor(section["accel"], files_internal::AccelKeys(), named, model.accel);
  const bool own_figures = !files_internal::SameNoise(model.gyro, preset.gyro) ||
                           !files_internal::SameNoise(model.accel, preset.accel);
  if (own_figures) {
    model.name = named ? ReadName(named) + " with own figures" : "own figures";
    model.source = std::filesystem::path(section.where().file).filename().string();
    model.approximate = false;
  }
  return model;
}

}  // namespace dn
