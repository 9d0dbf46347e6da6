#pragma once

#include <dn/geo/local_frame.h>
#include <dn/gnss/gnss_data.h>
#include <dn/sim/scenario.h>

#include <cstdint>

namespace dn {

/// Puts the scenario's GNSS effects that act on finished positions and tags into the data:
/// correlated noise, position steps, gross errors, outages, offsets and steps of the time tags.
/// Without `noise` the random ones are left out. Throws InvalidConfig when nothing is left, or a
/// clock steps back over an epoch.
void ApplyGnssEffects(const Scenario& scenario, const LocalFrame& frame, std::uint64_t seed,
                      bool noise, GnssData* data);

}  // namespace dn
