#pragma once

#include <dn/study/study.h>

#include <vector>

namespace dn {

/// A changed scenario.
struct Remedy {
  RemedyKind kind;
  Scenario scenario;
};

/// The changes that a scenario calls for: what its strips have in common, varied by one more strip;
/// and twice the pairs. None for the replay of a trajectory.
std::vector<Remedy> RemediesFor(const Scenario& scenario, const FlightGeometry& geometry);

/// Tries them and fills StudyDirection::tried. Those that cannot be flown, and those that leave the
/// design singular, are left out.
void TryRemedies(const std::vector<Remedy>& remedies, const DesignOptions& options,
                 std::vector<StudyDirection>* directions);

}  // namespace dn
