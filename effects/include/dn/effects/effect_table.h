#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dn {

/// What an effect touches first.
enum class EffectSensor { kGnss, kImu, kGyro, kAccel, kLidar, kPairs, kTrajectory };

/// What the values of an effect are.
enum class EffectKind {
  kFixed,       ///< a few constants: may be an unknown of the adjustment (`estimate:`)
  kStochastic,  ///< random numbers: noise, processes, gross errors
  kFault        ///< a fault of the data that no unknown models
};

/// When an effect is there, and the key that says so beside it.
enum class EffectTiming {
  kFlight,  ///< the whole flight; no key
  kWindow,  ///< `window_s: [begin, end]`, both included
  kStart    ///< `t0_s`: from then on
};

/// One number of an effect's value.
struct EffectComponent {
  std::string name;  ///< "x", "east", "tau"
  std::string unit;  ///< as in files: "ppm", "deg/h"; "1" for a ratio or a share
  double to_si;      ///< SI (radian) = to_si * value
  double typical;    ///< size to expect, 1 sigma, in `unit`; of a ratio the ratio itself
  double lowest;     ///< of the value in `unit`, this included
  double highest;

  double typical_si() const { return typical * to_si; }
};

/// What the simulator, the estimator and the documents know of an effect: everything but its
/// physics. An effect is something that the data contain and the assumed model lacks; its value is
/// what was added to the truth.
struct EffectSpec {
  std::string name;
  EffectSensor sensor;
  EffectKind kind;
  EffectTiming timing;
  /// In the order of the value; empty for an effect without one. Those of a fixed effect share one
  /// unit.
  std::vector<EffectComponent> components;
};

/// Every effect; docs/reference/effects.md has the same table with the meaning of each.
const std::vector<EffectSpec>& EffectTable();

/// The effect of this name; nullptr where there is none.
const EffectSpec* FindEffect(std::string_view name);

/// Names in the order of the table, of all effects or of one kind.
std::vector<std::string> EffectNames(std::optional<EffectKind> kind = std::nullopt);

/// "window_s", "t0_s", or empty.
std::string TimingKey(EffectTiming timing);

/// What is wrong with a value in file units: the number of its components or a bound, by name;
/// nothing when it is good.
std::optional<std::string> ValueFault(const EffectSpec& effect, const std::vector<double>& value);

/// A value in file units, as long as `components`, in SI.
Eigen::VectorXd ValueInSi(const EffectSpec& effect, const std::vector<double>& value);

/// The size to expect of every component, in SI.
Eigen::VectorXd TypicalInSi(const EffectSpec& effect);

}  // namespace dn
