#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/adjustment/control_checks.h>
#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "unmodelled.h"

namespace dn::diagnosis_internal {

/// Returns the deviations of all control points, as blocks.
std::vector<BlockId> ControlDeviations(const FlightNetwork& network);

/// Returns the derivatives of the surveys by a constant shift of the control against GNSS, local
/// east, north, up. Empty if the network has no active survey, or estimates the shift.
EffectModel ControlShiftColumns(const FlightNetwork& network);

/// Results of the unmodelled effects that the check of the control uses.
struct ControlCheckInput {
  const Adjustment& adjustment;
  const Marginals& marginals;
  const UnmodelledUnknowns& unmodelled;
  /// First row of the deviations in JointScore::shift; its first three rows are the boresight.
  Eigen::Index first_row = 0;
  bool of_boresight = false;
  std::optional<std::size_t> shift_block;  ///< of ControlShiftColumns, in the score
};

/// Tests every control point against all other data, with the unmodelled effects as unknowns.
/// Returns nullopt if the network has no control.
std::optional<ControlCheck> CheckControl(const ControlCheckInput& input);

}  // namespace dn::diagnosis_internal
