#pragma once

#include <dn/builder/flight_network.h>

namespace dn::internal {

/// The network of a flight that differs from that of `solved` in its configuration only, unsolved,
/// where `solved` stands: its trajectory, calibration and mean biases, the same pairs and GNSS epochs
/// in use. A step of least squares is enough for what hardly moves the solution. The flight must
/// outlive it. Throws as Build.
FlightNetwork NetworkBeside(const FlightNetwork& solved, const Flight& flight, int threads);

}  // namespace dn::internal
