#pragma once

#include <cstdint>
#include <filesystem>

namespace paper {

/// A constant attitude offset of the trajectory is absorbed by the boresight (biased LAR and HAR).
void AbsorbOffsets(std::uint64_t seed, const std::filesystem::path& folder);

/// The adjustment started 5 deg per axis from nowhere, with the exponential and with the paper's
/// small-angle rotation.
void StartFarAway(std::uint64_t seed, const std::filesystem::path& folder);

/// Pairs thinned from 30 Hz to one in 20 s (HAR, four strips).
void ThinPairs(std::uint64_t seed, const std::filesystem::path& folder);

}  // namespace paper
