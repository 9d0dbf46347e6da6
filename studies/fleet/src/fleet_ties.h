#pragma once

#include <dn/fleet/fleet.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "fleet_likelihood.h"
#include "fleet_unknowns.h"
#include "tie_likelihood.h"

namespace dn::fleet_internal {

/// The ties that take part in an adjustment of flights.
struct UsedTies {
  std::vector<Tie> ties;
  FleetTies report;
};

/// Screens the ties of the flights and adds their likelihood. Returns nullopt without ties.
std::optional<UsedTies> AddTies(const std::vector<ReducedFlight>& flights,
                                const SharedUnknowns& shared, FleetLikelihood* likelihood);

/// Adds the likelihood of the ties to that of one boresight by the pure model: b^T N b - 2 b^T g,
/// with the left rotation b from the reference.
void AddModelledTies(const std::vector<ReducedFlight>& flights, const UsedTies& ties,
                     const Eigen::Vector3d& reference_rad, Eigen::Matrix3d* N, Eigen::Vector3d* g);

}  // namespace dn::fleet_internal
