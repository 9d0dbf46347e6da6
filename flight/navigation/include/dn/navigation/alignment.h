#pragma once

#include <dn/builder/flight_nodes.h>
#include <dn/flight/flight.h>
#include <dn/navigation/forward_filter.h>

#include <functional>
#include <string>
#include <vector>

namespace dn {

/// Starting trajectory of a flight, found without any outside attitude.
struct Alignment {
  FilterRun run;             ///< states at the requested times
  std::string method;        ///< "in-flight", "gyrocompass", "levelling", "initial guess"
  int candidates = 0;        ///< attitudes that were compared
  double heading_rad = 0.0;  ///< at the first epoch
};

/// Finds the attitude at the first of `times` and runs the forward filter over all of them.
///
/// Candidates: the initial guess where the flight has one; the solution of Wahba's problem between
/// twice integrated specific force and second differences of the GNSS positions in the inertial
/// frame (exact for a rotating Earth, needs a turn or another horizontal acceleration);
/// gyrocompassing when at rest with a gyro that resolves the Earth rate; else levelling with eight
/// headings. Each is judged by the likelihood of the forward filter's innovations, and the best is
/// refined by running it twice more. `interrupted` is polled all the while; true throws
/// Interrupted.
Alignment Align(const Flight& flight, const std::vector<double>& times,
                const std::function<bool()>& interrupted = {});

}  // namespace dn
