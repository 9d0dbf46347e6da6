#pragma once

#include <dn/flight/flight.h>
#include <dn/gap/diagnose.h>
#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "screen.h"

namespace dn::internal {

/// A named effect, and those that the flight cannot tell it from.
struct Tie {
  GapCause named;
  std::vector<std::string> rivals;
};

/// The ties of a verdict that a further strip could break: between fixed effects that last for the
/// whole flight.
std::vector<Tie> TiesOf(const GapDiagnosis& diagnosis);

/// Noncentrality of the named effect, at its estimate, beside a rival whose size is free: what the
/// data say for the one and against the other is half of it in the mean [nats]. Infinite where the
/// screen has only one of them.
double Separation(const Screen& screen, const GapCause& named, const std::string& rival);

/// What to fly: of one more strip, across the flight's own, against the first, higher or faster, the
/// one that tells the most rivals of a tie from the named effect. The flight is planned anew with
/// its strips as straight lines, and with the further one; by geometry alone. Empty where the flight
/// cannot be planned or none helps.
std::string TieBreaker(const Flight& flight, const Trajectory& estimated,
                       const Eigen::Vector3d& boresight_rad, const Tie& tie,
                       const GapOptions& options);

}  // namespace dn::internal
