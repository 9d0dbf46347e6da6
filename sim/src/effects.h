#pragma once

#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

struct EffectDescription {
  enum class Timing { kAlways, kWindow, kStart };
  std::string name;
  std::size_t values;  ///< length of `value`
  bool simulated;      ///< by this version
  Timing timing = Timing::kAlways;
};

/// Every effect that a scenario may name: first those that are also unknowns of the estimator and
/// causes of the diagnosis, then faults of the data.
const std::vector<EffectDescription>& KnownEffects();

/// The scenario's entries of one effect.
std::vector<const Effect*> EffectsNamed(const Scenario& scenario, const std::string& name);

/// Sum of an effect's three values over the scenario's entries; zero when it has none.
Eigen::Vector3d VectorEffect(const Scenario& scenario, const std::string& name);
/// Same for an effect of one value.
double ScalarEffect(const Scenario& scenario, const std::string& name);
/// Product of an effect's ratios; 1 when it has none.
double RatioEffect(const Scenario& scenario, const std::string& name);

}  // namespace dn
