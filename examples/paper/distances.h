#pragma once

namespace paper {

/// Prints how far the published boresights are from their references, beside the published sigmas
/// and those that a study of the same geometry and sensors predicts. No flight is simulated.
void PrintDistances();

}  // namespace paper
