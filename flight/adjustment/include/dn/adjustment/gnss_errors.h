#pragma once

#include <dn/calibration/adjust.h>
#include <dn/calibration/finding.h>
#include <dn/report/json.h>
#include <dn/solvers/marginals.h>

#include <optional>
#include <string>

namespace dn {

/// `gnss_errors` of report.json: the test for errors of the GNSS positions that last (null where it
/// was not made), and what each of gnss.processes came out as: number of states, root mean square
/// of the estimates and of their standard deviations over the states, east, north, up, m.
/// `marginals` must have its selected inverse.
Json GnssErrorsJson(const Adjustment& adjustment, const Marginals& marginals);

/// gnss_errors.txt: at every GNSS epoch of the network t, the sum of the processes east, north, up
/// [m], and its standard deviations. `marginals` must have its selected inverse.
std::string FormatGnssErrors(const FlightNetwork& network, const Marginals& marginals);

/// facts::GnssErrorsLast where the test finds errors that last. Nothing elsewhere.
std::optional<Finding> WarningOfGnssErrors(const Adjustment& adjustment);

}  // namespace dn
