#pragma once

#include <dn/builder/flight_nodes.h>
#include <dn/files/flight.h>
#include <dn/navigation/forward_filter.h>

#include <functional>
#include <string>
#include <vector>

namespace dn {

/// Initial trajectory of a flight, found without an external attitude.
struct Alignment {
  FilterRun run;             ///< states at the requested times
  std::string method;        ///< "in-flight", "gyrocompass", "levelling", "initial guess"
  int candidates = 0;        ///< number of initial attitudes compared
  double heading_rad = 0.0;  ///< heading at the first epoch, clockwise from north
};

/// Finds the attitude at the first of `times` and runs the forward filter over all of them.
///
/// The candidates for the attitude are:
/// - the initial guess, if the flight has one;
/// - the solution of Wahba's problem between twice integrated specific force and second differences
///   of the GNSS positions in the inertial frame (exact for a rotating Earth; it needs a turn or
///   another horizontal acceleration);
/// - gyrocompassing, if the vehicle is at rest and the gyro resolves the Earth rate;
/// - otherwise levelling with eight headings.
///
/// The candidate with the largest likelihood of the forward filter's innovations is selected and
/// refined by two more filter runs. `interrupted` is polled during all runs; if it returns true,
/// Interrupted is thrown. Throws InvalidInput if no candidate can be found.
Alignment Align(const Flight& flight, const std::vector<double>& times,
                const std::function<bool()>& interrupted = {});

}  // namespace dn
