#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/adjustment/finding.h>
#include <dn/report/json.h>
#include <dn/solvers/marginals.h>

#include <optional>
#include <string>

namespace dn {

/// Returns `gnss_errors` of report.json: the test for time-correlated errors of the GNSS positions
/// (null if not made), and a summary of each of gnss.processes. A summary has the number of states.
/// It also has the root mean squares, over the states, of the estimates and of their standard
/// deviations; east, north, up, m. `marginals` must have its selected inverse.
Json GnssErrorsJson(const Adjustment& adjustment, const Marginals& marginals);

/// Returns the text of gnss_errors.txt: per GNSS epoch of the network t, the sum of the processes
/// east, north, up [m], and its standard deviations. `marginals` must have its selected inverse.
std::string FormatGnssErrors(const FlightNetwork& network, const Marginals& marginals);

/// Returns facts::GnssErrorsCorrelated if the test finds time-correlated errors, otherwise nullopt.
std::optional<Finding> GnssErrorWarning(const Adjustment& adjustment);

}  // namespace dn
