#pragma once

#include <dn/diagnosis/diagnose.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>

#include <Eigen/Core>
#include <string>
#include <vector>

#include "screen.h"

namespace dn::diagnosis_internal {

/// A named effect, and the effects that the flight cannot separate from it.
struct Tie {
  GapCause named;
  std::vector<std::string> competing_effects;
};

/// Returns the ties of a verdict that one more strip could break: those between fixed effects that
/// act during the whole flight.
std::vector<Tie> FindTies(const GapDiagnosis& diagnosis);

/// Returns the noncentrality of the named effect, at its estimate, against another effect of free
/// size. The mean evidence for the named effect is half of it, nats. Returns infinity if the screen
/// lacks one of them.
double Separation(const Screen& screen, const GapCause& named, const std::string& other);

/// Returns what to fly: the additional strip that separates the most effects of a tie from the
/// named effect. The choices are a strip across the others, one along the first in the opposite
/// direction, one higher and one faster. The flight is planned again, with its strips and the
/// additional one as straight lines, by geometry alone. Returns "" if the flight cannot be planned
/// or no strip helps.
std::string ProposeTieBreaker(const Flight& flight, const Trajectory& estimated,
                              const Eigen::Vector3d& boresight_rad, const Tie& tie,
                              const GapOptions& options);

}  // namespace dn::diagnosis_internal
