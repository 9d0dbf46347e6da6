#pragma once

#include <dn/gap/diagnose.h>

#include "screen.h"

namespace dn::internal {

/// Whether the flight has poses at which a network can be linearised without being solved: a
/// trajectory, an initial guess or a reference.
bool HasPoses(const Flight& flight);

/// The library at the poses of a flight, from its configuration and the laser vectors of its pairs.
/// Inertial and GNSS data that it has not are those of perfect sensors on these poses. `flight` has
/// the section imu. Throws as Build, and RankDeficient. `rows`: of the network; may be null.
Screen ScreenOfDesign(const Flight& flight, const GapOptions& options, long* rows = nullptr);

/// What could be found and what could hide on a flight, by ScreenOfDesign. Throws as that.
GapResult LimitsOfDesign(const Flight& flight, const GapOptions& options);

}  // namespace dn::internal
