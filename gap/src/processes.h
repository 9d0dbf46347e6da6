#pragma once

#include <dn/calibration/adjust.h>
#include <dn/flight/flight.h>
#include <dn/gap/diagnosis.h>

#include <functional>
#include <string>
#include <vector>

#include "screen.h"

namespace dn::internal {

/// A process as states of the network, at the time constants that are tried: the evidence by the
/// restricted likelihood of its sigma, exact where the cosines of the screen are cut short.
/// `beside`: effects that are in the network, too; `adjust` solves a flight. A time constant at
/// which it cannot be solved is left out; nothing is changed where none can.
void JudgeProcess(const Flight& flight, const std::vector<GapCause>& beside,
                  const std::function<Adjustment(const Flight&)>& adjust, int threads,
                  ScreenedEffect* effect);

}  // namespace dn::internal
