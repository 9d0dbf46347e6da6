#pragma once

#include <dn/adjustment/clocks.h>
#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>

#include "hypothesis.h"

namespace dn::diagnosis_internal {

/// Returns offset and drift of each clock, from its unknowns or else, to first order, from the
/// scores of the library.
Clocks EstimateClocks(const FlightNetwork& network, const Marginals& marginals,
                      const Library& library, const JointScore& score);

/// Returns the shift of the watched unknowns, the first `watched` of the score, by this error of
/// the GNSS clock.
Eigen::VectorXd ShiftByGnssClock(const ClockEstimate& clock, const Library& library,
                                 const JointScore& score, Eigen::Index watched);

}  // namespace dn::diagnosis_internal
