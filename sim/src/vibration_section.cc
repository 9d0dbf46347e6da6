#include "vibration_section.h"

#include <dn/files/file_units.h>
#include <dn/geo/text_table.h>
#include <dn/names.h>

#include <cmath>
#include <vector>

namespace dn {
namespace {

constexpr std::size_t kMostParts = 50;
constexpr int kMostHarmonics = 20;
constexpr double kHighest_hz = 2000.0;
// A slower vibration would move the body by centimetres; turbulence describes such motion.
constexpr double kLowest_hz = 0.5;
constexpr double kMostAccel_mps2 = 100.0;
constexpr double kMostAngle_urad = 1e4;
constexpr double kMostWander_percent = 10.0;
constexpr double kLeastDamping = 1e-3, kMostDamping = 0.7;

double FromMicro(double micro) { return 1e-6 * micro; }
double FromPercent(double percent) { return 0.01 * percent; }
double Same(double value) { return value; }

double ReadBetween(const YamlValue& value, double low, double high) {
  const double number = value.Number();
  if (number < low || number > high) {
    value.Fail("must lie between " + FormatDouble(low) + " and " + FormatDouble(high));
  }
  return number;
}

double ReadFrequency(const YamlValue& value) { return ReadBetween(value, kLowest_hz, kHighest_hz); }

/// Reads the rms of each axis; one number applies to all axes.
Eigen::Vector3d ReadRms(const YamlValue& value, double most) {
  if (!value) return Eigen::Vector3d::Zero();
  Eigen::Vector3d rms =
      value.IsScalar() ? Eigen::Vector3d::Constant(value.Number()).eval() : ReadVector3(value);
  if (rms.minCoeff() < 0.0 || rms.maxCoeff() > most) {
    value.Fail("must lie between 0 and " + FormatDouble(most));
  }
  return rms;
}

VibrationLevel ReadLevel(const YamlValue& part) {
  return {ReadRms(part["accel_m_s2"], kMostAccel_mps2),
          ReadRms(part["angle_urad"], kMostAngle_urad).unaryExpr(&FromMicro)};
}

VibrationLine ReadLine(const YamlValue& part) {
  part.ExpectMap({"frequency_hz", "accel_m_s2", "angle_urad", "harmonics", "wander_percent"});
  VibrationLine line;
  line.frequency_hz = ReadFrequency(part["frequency_hz"]);
  line.level = ReadLevel(part);
  if (part["harmonics"]) line.harmonics = static_cast<int>(part["harmonics"].Integer(1));
  if (line.harmonics > kMostHarmonics || line.harmonics * line.frequency_hz > kHighest_hz) {
    part["harmonics"].Fail("at most " + std::to_string(kMostHarmonics) + ", up to " +
                           FormatDouble(kHighest_hz) + " Hz, are possible");
  }
  if (part["wander_percent"]) {
    line.wander = FromPercent(ReadBetween(part["wander_percent"], 0.0, kMostWander_percent));
  }
  return line;
}

VibrationResonance ReadResonance(const YamlValue& part) {
  part.ExpectMap({"frequency_hz", "damping", "accel_m_s2", "angle_urad"});
  return {ReadFrequency(part["frequency_hz"]),
          part["damping"] ? ReadBetween(part["damping"], kLeastDamping, kMostDamping) : 0.05,
          ReadLevel(part)};
}

VibrationBand ReadBand(const YamlValue& part) {
  part.ExpectMap({"low_hz", "high_hz", "accel_m_s2", "angle_urad"});
  VibrationBand band{ReadFrequency(part["low_hz"]), ReadFrequency(part["high_hz"]),
                     ReadLevel(part)};
  if (!(band.high_hz > band.low_hz)) part["high_hz"].Fail("must be higher than low_hz");
  return band;
}

VibrationScenario ReadPreset(const YamlValue& name) {
  const std::string text = ReadName(name);
  if (text == "none") return {};
  if (const auto vibration = VibrationPreset(text)) return *vibration;
  std::vector<std::string> names = VibrationPresetNames();
  names.emplace_back("none");
  name.Fail("'" + text + "' is not a preset; did you mean '" + NearestName(text, names) +
            "'? Presets: " + JoinNames(names) + "; or a map with lines, resonances and broadband");
}

std::string Rms(const Eigen::Vector3d& rms, ToSi to_si) {
  std::string text;
  for (const double value : rms) {
    text += (text.empty() ? "" : ", ") + FormatDouble(InUnit(value, to_si));
  }
  return "[" + text + "]";
}

std::string Level(const VibrationLevel& level) {
  return ", accel_m_s2: " + Rms(level.accel_mps2, &Same) +
         ", angle_urad: " + Rms(level.angle_rad, &FromMicro);
}

std::string Format(const VibrationLine& line) {
  return "{frequency_hz: " + FormatDouble(line.frequency_hz) + Level(line.level) +
         ", harmonics: " + std::to_string(line.harmonics) +
         ", wander_percent: " + FormatDouble(InUnit(line.wander, &FromPercent)) + "}";
}

std::string Format(const VibrationResonance& resonance) {
  return "{frequency_hz: " + FormatDouble(resonance.frequency_hz) +
         ", damping: " + FormatDouble(resonance.damping) + Level(resonance.level) + "}";
}

std::string Format(const VibrationBand& band) {
  return "{low_hz: " + FormatDouble(band.low_hz) + ", high_hz: " + FormatDouble(band.high_hz) +
         Level(band.level) + "}";
}

template <class Part>
std::string FormatList(const std::vector<Part>& parts) {
  std::string text;
  for (const Part& part : parts) text += (text.empty() ? "" : ", ") + Format(part);
  return "[" + text + "]";
}

}  // namespace

VibrationScenario ReadVibration(const YamlValue& section) {
  if (!section) return {};
  if (section.IsScalar()) return ReadPreset(section);
  section.ExpectMap({"lines", "resonances", "broadband"});
  VibrationScenario vibration;
  const auto each = [&](const char* key, const auto& read) {
    if (!section[key]) return;
    for (const YamlValue& part : section[key].List(kMostParts)) read(part);
  };
  each("lines", [&](const YamlValue& part) { vibration.lines.push_back(ReadLine(part)); });
  each("resonances",
       [&](const YamlValue& part) { vibration.resonances.push_back(ReadResonance(part)); });
  each("broadband", [&](const YamlValue& part) { vibration.broadband.push_back(ReadBand(part)); });
  return vibration;
}

std::string FormatVibration(const VibrationScenario& vibration) {
  if (vibration.preset) return *vibration.preset;
  if (vibration.empty()) return "none";
  return "{lines: " + FormatList(vibration.lines) +
         ", resonances: " + FormatList(vibration.resonances) +
         ", broadband: " + FormatList(vibration.broadband) + "}";
}

}  // namespace dn
