#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Root mean square of a vibration about each body axis.
struct VibrationLevel {
  Eigen::Vector3d accel_mps2 = Eigen::Vector3d::Zero();  ///< acceleration
  Eigen::Vector3d angle_rad = Eigen::Vector3d::Zero();   ///< rotation
};

/// Vibration of an engine or a rotor: a line with its harmonics.
struct VibrationLine {
  double frequency_hz = 0.0;
  VibrationLevel level;  ///< of the fundamental
  /// Number of lines: the fundamental and its multiples. The acceleration of harmonic n is 1/n of
  /// that of the fundamental, and its rotation is 1/n^3.
  int harmonics = 1;
  double wander = 0.0;  ///< relative rms of the slow changes of the frequency
};

/// Vibration of a structure with one resonance, excited by white forces.
struct VibrationResonance {
  double frequency_hz = 0.0;
  double damping = 0.0;  ///< fraction of the critical damping
  VibrationLevel level;
};

/// Vibration with a constant density of the acceleration between two frequencies.
struct VibrationBand {
  double low_hz = 0.0;
  double high_hz = 0.0;
  VibrationLevel level;
};

/// Vibration of the platform. It is true motion of the body, seen by every sensor.
struct VibrationScenario {
  std::optional<std::string> preset;  ///< absent if the parts are given explicitly
  std::vector<VibrationLine> lines;
  std::vector<VibrationResonance> resonances;
  std::vector<VibrationBand> broadband;

  bool empty() const { return lines.empty() && resonances.empty() && broadband.empty(); }
};

/// Returns the names of the presets, without `none`.
std::vector<std::string> VibrationPresetNames();

/// Returns the vibration of a preset; nullopt for an unknown name.
std::optional<VibrationScenario> VibrationPreset(const std::string& name);

}  // namespace dn
