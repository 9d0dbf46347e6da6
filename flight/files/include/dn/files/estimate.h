#pragma once

#include <dn/error.h>
#include <dn/flight/effect_times.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// One entry of `estimate:`: the boresight, or a fixed effect.
struct EstimateEntry {
  std::string unknown;
  /// Prior in the effect's unit: one number per component, one for all of them, or none.
  std::vector<double> sigma{};
  EffectTimes times{};
  FileLocation where{};  ///< in flight.yaml
};

/// The prior of an effect's components in SI; nothing where the entry has none. Throws InvalidInput
/// where it is no fixed effect, or the number of sigmas is neither one nor that of its components.
std::optional<Eigen::VectorXd> PriorSigma(const EstimateEntry& entry);

}  // namespace dn
