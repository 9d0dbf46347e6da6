#pragma once

#include <cstdint>
#include <filesystem>

namespace paper {

/// Shows that the boresight absorbs a constant attitude offset of the trajectory (biased LAR and
/// HAR).
void AbsorbOffsets(std::uint64_t seed, const std::filesystem::path& folder);

/// Starts the adjustment 5 deg per axis from the truth, with the exponential and with the paper's
/// small-angle rotation.
void StartFarAway(std::uint64_t seed, const std::filesystem::path& folder);

/// Thins pairs from 30 Hz to one in 20 s (HAR, four strips).
void ThinPairs(std::uint64_t seed, const std::filesystem::path& folder);

}  // namespace paper
