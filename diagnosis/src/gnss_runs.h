#pragma once

#include <dn/adjustment/checks.h>
#include <dn/builder/flight_network.h>
#include <dn/network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <vector>

#include "evidence.h"

namespace dn::diagnosis_internal {

/// Log of the ratio of two likelihoods of the residuals r of GNSS positions that were left out. The
/// residuals are predicted minus measured positions, whitened with the stated noise:
///
///   GNSS is wrong      r ~ N(L b, H + (1 + s^2) I)    one offset b and noise of another size s
///   inertial is wrong  r ~ N(0, k^2 H + I)            the trajectory errs k times as much
///
/// H is the covariance of the whitened trajectory. b, s and k are the likeliest ones. The offset
/// costs 3/2 ln(n) nats (Schwarz 1978), n the number of residuals.
double LogGnssOverInertial(const Eigen::VectorXd& r, const Eigen::MatrixXd& H,
                           const Eigen::MatrixXd& L);

/// Checks the runs of GNSS positions that the adjustment left out. Short runs have no shape from
/// which the wrong sensor could be told, and are omitted. `watched` are the blocks of the
/// coordinates of `family.watched_sigma`.
std::vector<GnssRunCheck> CheckGnssRuns(const FlightNetwork& network, const Marginals& marginals,
                                        const std::vector<BlockId>& watched,
                                        const TestFamily& family);

}  // namespace dn::diagnosis_internal
