#pragma once

namespace dn {

/// Number of a beam that is unknown, or of a point that several beams measured. The beams of a
/// scanner have the numbers from 0 on.
inline constexpr int kNoBeam = -1;

/// Largest number of beams of a scanner.
inline constexpr int kMostBeams = 1024;

}  // namespace dn
