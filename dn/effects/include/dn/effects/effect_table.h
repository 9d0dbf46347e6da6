#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dn {

/// Identifies an effect; in the order of the table.
enum class EffectId {
  kGnssLeverArm,
  kGnssTimeOffset,
  kGnssTimeDrift,
  kGnssCorrelatedNoise,
  kGnssMultipath,
  kGnssPositionStep,
  kGnssNoiseScale,
  kGyroScaleFactor,
  kAccelScaleFactor,
  kGyroMisalignment,
  kAccelMisalignment,
  kGyroGSensitivity,
  kGyroBiasProcess,
  kAccelBiasProcess,
  kGyroNoiseScale,
  kAccelNoiseScale,
  kImuVibration,
  kGravityTilt,
  kGravityDisturbance,
  kLidarLeverArm,
  kLidarTimeOffset,
  kLidarTimeDrift,
  kLidarRangeOffset,
  kLidarRangeScale,
  kLidarAngleScale,
  kLidarScanCone,
  kLidarScanTorsion,
  kBoresightDrift,
  kBoresightStep,
  kP2pNoiseScale,
  kP2pOutliers,
  kP2pRangeNoise,
  kTrajectoryAttitudeOffset,
  kGnssOutage,
  kGnssOutliers,
  kGnssClockStep,
  kImuGap,
  kImuClockStep,
};

/// Sensor, measurements or trajectory that an effect acts on first.
enum class EffectSensor { kGnss, kImu, kGyro, kAccel, kLidar, kPairs, kTrajectory };

/// Nature of the value of an effect.
enum class EffectKind {
  kFixed,     ///< a few constants: can be unknowns of the adjustment (`estimate:`)
  kProcess,   ///< a Gauss-Markov process: standard deviations, then the time constant
  kNoise,     ///< a different magnitude of the white noise
  kOutliers,  ///< outliers: their fraction, then their largest size
  kFault      ///< a fault of the data without a parametric model
};

/// Time span of an effect, and the key of the file that gives it.
enum class EffectTiming {
  kFlight,  ///< during the whole flight; needs no key
  kWindow,  ///< inside `window_s: [begin, end]`, both ends included
  kStart    ///< from `t0_s` on
};

/// One component of the value of an effect.
struct EffectComponent {
  std::string name;  ///< such as "x", "east", "tau"
  std::string unit;  ///< as in files: "ppm", "deg/h"; "1" for a ratio or a fraction
  double to_si;      ///< SI (radian) = to_si * value
  double typical;    ///< typical magnitude (1 sigma) in `unit`; for a ratio the ratio itself
  double lowest;     ///< smallest allowed value in `unit`, itself allowed
  double highest;    ///< largest allowed value in `unit`, itself allowed

  double typical_si() const { return typical * to_si; }
};

/// Description of an effect that simulator, estimator and documents share; it contains no physics.
/// An effect is an error that the data contain and the assumed model lacks. Its value is the error
/// added to the truth.
struct EffectSpec {
  EffectId id;
  std::string name;  ///< as in `effects:` of a scenario and `estimate:` of a flight
  EffectSensor sensor;
  EffectKind kind;
  EffectTiming timing;
  /// Components in the order of the value; empty for an effect without a value. All components of a
  /// fixed effect have the same unit.
  std::vector<EffectComponent> components;
  /// As a free unknown, the effect keeps the first INS/GNSS solution from converging.
  bool needs_prior = false;

  bool fixed() const { return kind == EffectKind::kFixed; }
  bool process() const { return kind == EffectKind::kProcess; }
  /// True for effects whose data are random numbers: processes, noise and outliers.
  bool random() const { return kind != EffectKind::kFixed && kind != EffectKind::kFault; }
};

/// Returns every effect. docs/reference/effects.md contains the same table with the meaning of each
/// effect.
const std::vector<EffectSpec>& EffectTable();

/// Returns the table row of an effect.
const EffectSpec& EffectRow(EffectId id);

/// Returns the name of an effect in files.
const std::string& EffectName(EffectId id);

/// Returns the effect of this name; nullptr if there is no such effect. The name of an unknown of
/// one scanner, `effect/scanner`, gives its effect.
const EffectSpec* FindEffect(std::string_view name);

/// Returns whether `name` is the name of this effect.
bool IsEffect(std::string_view name, EffectId id);

/// Returns the names of all effects, or of those of one kind, in the order of the table.
std::vector<std::string> EffectNames(std::optional<EffectKind> kind = std::nullopt);

/// Returns the key that gives the time span: "window_s", "t0_s", or an empty text for kFlight.
std::string TimingKey(EffectTiming timing);

/// Checks a value in file units. Returns nullopt if it is valid, else a message about the wrong
/// number of components or the component out of bounds.
std::optional<std::string> ValueFault(const EffectSpec& effect, const std::vector<double>& value);

/// Converts a value from file units to SI. `value` must have as many elements as `components`.
Eigen::VectorXd ValueInSi(const EffectSpec& effect, const std::vector<double>& value);

/// Returns the typical magnitude of every component, in SI.
Eigen::VectorXd TypicalInSi(const EffectSpec& effect);

}  // namespace dn
