#pragma once

#include <dn/blind_check/described_physics.h>
#include <dn/blind_check/outsider.h>
#include <dn/sim/simulate.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Content of a flight: no effect, one, two, three, one outside the library of effects, or one
/// effect that the diagnosis must not consider (kLeftOut).
enum class BlindContent {
  kNothing,
  kOneEffect,
  kTwoEffects,
  kThreeEffects,
  kUnlistedEffect,
  kLeftOut
};

/// Returns the number of effects of the table in a flight with this content.
std::size_t EffectCount(BlindContent content);

/// A series of flights with effects that are unknown to the diagnosis.
struct BlindSuite {
  std::uint64_t seed = 1;
  std::vector<std::string> scenarios;  ///< base scenarios of the flights, at least one
  /// Content of every flight; nullopt: drawn for each flight, but never kThreeEffects or kLeftOut.
  std::optional<BlindContent> only = {};
  double size_factor = 1.0;  ///< on the sizes of the effects of the table, positive
  /// Effects outside the library that flights may contain; empty: those of UnlistedEffectNames.
  std::vector<DescribedPhysics> physics = {};
  std::vector<std::string> changes = {};  ///< of every base scenario, "key=value"
};

/// One flight of a series.
struct BlindFlight {
  int number = 1;
  std::uint64_t seed = 1;  ///< seed of the simulation
  std::string base;        ///< base scenario
  Scenario scenario;       ///< drawn scenario with at most three effects
  std::optional<UnlistedEffect> outsider;
  bool left_out = false;  ///< the diagnosis must not consider the effect

  BlindContent content() const;
};

/// Returns the shipped scenarios with sensor noise at rest. Only drawn effects deviate from their
/// assumed model.
std::vector<std::string> BlindScenarioNames();

/// Returns the largest component of an effect divided by its typical size in the table. For a
/// ratio r it is (r - 1) / (typical - 1).
double DrawnSize(const Effect& effect);

/// Returns the seed of the simulation of flight `number` in a suite of this seed.
std::uint64_t BlindFlightSeed(std::uint64_t suite_seed, int number);

/// Draws flight `number` (from 1): the lines (heading, height, length, number), the terrain, the
/// true boresight and the content, unless the suite prescribes it. 20 % of the flights contain no
/// effect, 50 % one, 10 % two, and 20 % an effect outside the library. The result depends only on
/// the suite and the number.
///
/// The logarithm of a size is uniform. Sizes are 1 to 10 times the typical size in the table. For a
/// ratio r, r - 1 is 0.5 to 4 times the typical one. Components that are not a size (a correlation
/// time, the length of outliers) are 0.5 to 2 times the typical value. The factor of the suite
/// multiplies the sizes of effects of the table. Faults are not drawn, since no diagnosis names
/// them.
/// Throws InvalidConfig if a scenario does not exist or replays a trajectory.
BlindFlight DrawBlindFlight(const BlindSuite& suite, int number);

}  // namespace dn
