#pragma once

#include <dn/geo/local_frame.h>
#include <dn/sim/scenario.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

struct EffectDescription {
  std::string name;
  std::size_t values;  ///< length of `value`
  bool simulated;      ///< by this version
};

/// Every effect of the contract, in its order.
const std::vector<EffectDescription>& KnownEffects();

/// Sum of an effect's three values over the scenario's entries; zero when it has none.
Eigen::Vector3d VectorEffect(const Scenario& scenario, const std::string& name);
/// Same for an effect of one value.
double ScalarEffect(const Scenario& scenario, const std::string& name);

}  // namespace dn
