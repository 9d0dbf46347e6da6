#pragma once

#include <dn/error.h>
#include <dn/files/effect_times.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// An entry of `estimate:`: the boresight or a fixed effect.
struct EstimateEntry {
  std::string unknown;  ///< of another scanner than the first: see ScannerName
  /// Prior sigma in the unit of the effect: one number per component, one number for all
  /// components, or empty for no prior.
  std::vector<double> sigma{};
  EffectTimes times{};
  FileLocation where{};   ///< place of the entry in flight.yaml
  std::string scanner{};  ///< scanner of a list whose unknown it is; empty: of the flight
};

/// Returns whether the unknown is the boresight of a scanner: `boresight` or `boresight/NAME`.
bool IsBoresight(const EstimateEntry& entry);

/// Returns the prior sigmas of the components of an effect in SI; nullopt if the entry has no
/// prior. Throws InvalidInput if it is not a fixed effect, or if the number of sigmas is neither
/// one nor the number of components.
std::optional<Eigen::VectorXd> PriorSigma(const EstimateEntry& entry);

}  // namespace dn
