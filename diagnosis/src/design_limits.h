#pragma once

#include <dn/diagnosis/diagnose.h>

#include "screen.h"

namespace dn::diagnosis_internal {

/// Returns whether the flight has poses at which a network can be linearised without a solution: a
/// trajectory, an initial guess or a reference.
bool HasPoses(const Flight& flight);

/// Screens the library at the poses of a flight, with its configuration and the laser vectors of
/// its pairs. Missing inertial and GNSS data are replaced by those of perfect sensors on these
/// poses. `flight` must have the section imu. `rows`, if not null, receives the number of rows of
/// the network. Throws as Build, and RankDeficient.
Screen ScreenDesign(const Flight& flight, const GapOptions& options, long* rows = nullptr);

/// Computes the detection limits of a flight with ScreenDesign, without a verdict. Throws as
/// ScreenDesign.
GapResult DiagnoseDesignLimits(const Flight& flight, const GapOptions& options);

}  // namespace dn::diagnosis_internal
