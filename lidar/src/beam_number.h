#pragma once

#include <dn/error.h>

#include <cstdint>

namespace dn::lidar_internal {

/// Returns the number of a beam. Throws InvalidInput at `where` unless it is an integer from 0 to
/// kMostBeams - 1.
std::uint16_t CheckedBeam(double value, const FileLocation& where);

/// Returns the beam of an end of a pair; kNoBeam is allowed in addition.
int CheckedPairBeam(double value, const FileLocation& where);

}  // namespace dn::lidar_internal
