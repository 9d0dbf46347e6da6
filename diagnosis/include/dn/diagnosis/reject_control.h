#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/diagnosis/solution.h>
#include <dn/files/flight.h>

#include <optional>

namespace dn {

/// Leaves out control points that contradict all other data at the level of the model check, one at
/// a time, the worst first. The flight is adjusted again from its solution each time. At most half
/// of the observations are left out, and none if a constant shift of the control explains more.
/// `solution` must be of `flight`, and made with `options`. Throws as Adjust.
void RejectWrongControl(const Flight& flight, const AdjustOptions& options,
                        std::optional<Solution>* solution);

}  // namespace dn
