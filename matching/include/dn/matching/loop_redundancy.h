#pragma once

#include <dn/matching/match.h>

namespace dn {

/// Multiplies the covariance of every pair, and the variance of every surface, by E / r. E strip
/// pairs have pairs or surfaces at its place, and r of them are independent. Three strips a,
/// b, c have the differences a - b, b - c and a - c. They contain the noise of three clouds, so the
/// third difference follows from the others. As independent pairs they would count the information
/// of the place 3 / 2 times.
///
/// The factor is exact if the strips at a place have equal, independent noise and all of them are
/// matched with each other. A place is the cell of the pair with all cells that overlap it.
void InflateLoops(MatchResult* result);

}  // namespace dn
