#pragma once

namespace paper {

/// Prints how far the published boresights are from their references. The published sigmas, and
/// those that a study of the same geometry and sensors predicts, are next to them. No flight is
/// simulated.
void PrintDistances();

}  // namespace paper
