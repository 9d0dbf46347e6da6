#include <dn/sim/vibration.h>

#include <algorithm>
#include <utility>

namespace dn {
namespace {

constexpr double kMicro = 1e-6;

VibrationLevel Level(const Eigen::Vector3d& accel_mps2, const Eigen::Vector3d& angle_urad) {
  return {accel_mps2, kMicro * angle_urad};
}

/// Light helicopter with three blades at 6.5 revolutions per second; the unit is on isolators.
VibrationScenario Helicopter() {
  VibrationScenario v;
  v.lines = {{6.5, Level({0.05, 0.08, 0.05}, {15.0, 10.0, 5.0}), 1, 0.005},
             {19.5, Level({0.15, 0.2, 0.4}, {8.0, 10.0, 4.0}), 3, 0.005},
             {69.0, Level({0.1, 0.2, 0.1}, {0.5, 0.3, 0.8}), 2, 0.005}};
  v.resonances = {{28.0, 0.08, Level({0.1, 0.1, 0.15}, {2.0, 2.0, 1.0})}};
  v.broadband = {{10.0, 300.0, Level({0.15, 0.15, 0.2}, {0.5, 0.5, 0.3})}};
  return v;
}

/// Piston engine at 2400 revolutions per minute with a propeller of three blades.
VibrationScenario LightAircraft() {
  VibrationScenario v;
  v.lines = {{40.0, Level({0.1, 0.1, 0.15}, {1.0, 1.5, 0.5}), 1, 0.003},
             {120.0, Level({0.2, 0.2, 0.3}, {0.3, 0.4, 0.2}), 3, 0.003}};
  v.resonances = {{14.0, 0.1, Level({0.05, 0.08, 0.1}, {4.0, 4.0, 2.0})}};
  v.broadband = {{10.0, 300.0, Level({0.1, 0.1, 0.1}, {0.3, 0.3, 0.2})}};
  return v;
}

/// Four rotors with two blades near 85 revolutions per second; the payload is on soft mounts.
VibrationScenario Multirotor() {
  VibrationScenario v;
  for (const double frequency_hz : {81.0, 84.0, 86.0, 90.0}) {
    v.lines.push_back({frequency_hz, Level({0.5, 0.5, 0.6}, {6.0, 6.0, 3.0}), 2, 0.02});
  }
  v.resonances = {{22.0, 0.1, Level({0.3, 0.3, 0.3}, {30.0, 30.0, 15.0})}};
  v.broadband = {{10.0, 300.0, Level({0.5, 0.5, 0.5}, {3.0, 3.0, 2.0})}};
  return v;
}

/// Engine with four cylinders near 1800 revolutions per minute, wheel hop and road.
VibrationScenario RoadVehicle() {
  VibrationScenario v;
  v.lines = {{60.0, Level({0.1, 0.1, 0.2}, {1.0, 1.5, 0.5}), 2, 0.05}};
  v.resonances = {{12.0, 0.2, Level({0.1, 0.1, 0.3}, {20.0, 20.0, 5.0})}};
  v.broadband = {{5.0, 100.0, Level({0.15, 0.15, 0.2}, {5.0, 5.0, 2.0})}};
  return v;
}

using Preset = std::pair<std::string, VibrationScenario (*)()>;

const std::vector<Preset>& Presets() {
  static const std::vector<Preset> presets{{"helicopter", &Helicopter},
                                           {"light_aircraft", &LightAircraft},
                                           {"multirotor", &Multirotor},
                                           {"car", &RoadVehicle}};
  return presets;
}

}  // namespace

std::vector<std::string> VibrationPresetNames() {
  std::vector<std::string> names;
  for (const Preset& preset : Presets()) names.push_back(preset.first);
  return names;
}

std::optional<VibrationScenario> VibrationPreset(const std::string& name) {
  for (const auto& [known, make] : Presets()) {
    if (known != name) continue;
    VibrationScenario vibration = make();
    vibration.preset = name;
    return vibration;
  }
  return std::nullopt;
}

}  // namespace dn
