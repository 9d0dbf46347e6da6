#pragma once

#include <dn/files/control.h>

namespace dn {

/// Reads the surface pairs that lidar.surface_pairs names (dn/lidar/surface_pairs.h).
///
/// Each pair becomes a plane with two returns. The position of the plane is not known, and p_m is
/// 0; each return has half of the variance of the pair. The name of a plane is PATH:LINE. The
/// result is empty if the flight names no files. Throws InvalidInput as ReadSurfacePairs does.
ControlData ReadSurfaces(const FlightConfig& config);

}  // namespace dn
