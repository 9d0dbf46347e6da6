#pragma once

#include <dn/builder/flight_network.h>

namespace dn {

/// Uses the survey of a control point of the network, or withholds it as that of a check. The
/// returns on a withheld point determine its deviation only, so that they are no residuals for the
/// tests of the fit.
void UseSurvey(const ControlNode& node, bool use, FlightNetwork* network);

}  // namespace dn
