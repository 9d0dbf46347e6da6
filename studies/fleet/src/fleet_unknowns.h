#pragma once

#include <dn/files/across.h>
#include <dn/fleet/reduced_flight.h>

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

namespace dn::fleet_internal {

/// An effect that has one value for several flights.
struct SharedEffect {
  EffectId effect;
  bool estimated = false;
  std::size_t group = 0;  ///< first flight of the place, or with the lever arm
  std::vector<Eigen::Index> components;
  Eigen::VectorXd prior_sigma;  ///< SI; the largest one that a flight states
  std::string remedy;
  Eigen::Index first = 0;  ///< column of the first component among all shared components
};

/// One component of a flight's posterior, and its column among all shared components.
struct SharedRow {
  Eigen::Index row = 0;  ///< in ReducedFlight::mean
  Eigen::Index column = 0;
  double prior_sigma = 0.0;  ///< that of the flight
};

/// The shared effects of a fleet and their places in each flight.
struct SharedUnknowns {
  std::vector<SharedEffect> effects;
  std::vector<std::vector<SharedRow>> rows;  ///< of each flight
  Eigen::Index size = 0;                     ///< number of components

  /// Returns the prior standard deviations of all components.
  Eigen::VectorXd PriorSigma() const;
};

/// Finds the effects that flights share. Throws InvalidConfig if a flight does not estimate an
/// unknown under `across`.
SharedUnknowns FindShared(const std::vector<ReducedFlight>& flights, const AcrossConfig& across);

}  // namespace dn::fleet_internal
