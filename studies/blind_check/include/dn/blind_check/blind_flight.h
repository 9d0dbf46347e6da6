#pragma once

#include <dn/montecarlo/outsider.h>
#include <dn/sim/simulate.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// What a flight of a series contains.
enum class BlindContent { kNothing, kOneEffect, kTwoEffects, kOutsider, kLeftOut };

/// A series of flights whose content their diagnosis does not know.
struct BlindSuite {
  std::uint64_t seed = 1;
  std::vector<std::string> scenarios;  ///< at least one; the flights are made from them
  /// What every flight contains; none: drawn for each. kLeftOut, which is not drawn: an effect of the
  /// table that its diagnosis has to do without.
  std::optional<BlindContent> only = {};
};

/// One flight of a series.
struct BlindFlight {
  int number = 1;
  std::uint64_t seed = 1;  ///< of its simulation
  std::string base;        ///< the scenario that it was made from
  Scenario scenario;       ///< with the effects, at most two
  std::optional<Outsider> outsider;
  bool left_out = false;  ///< its effect is none of those that its diagnosis considers

  BlindContent content() const;
};

/// Shipped scenarios whose sensors are at rest: nothing but what is drawn departs from their model.
std::vector<std::string> BlindScenarioNames();

/// Its largest component in usual sizes of the table; of a ratio r, (r - 1) / (usual - 1).
double SizeOf(const Effect& effect);

/// Draws flight `number`, from 1: the lines (heading, height, length, number), the terrain and the
/// true boresight; then what it contains: nothing in 20 % of the flights, one effect in 50, two in
/// 10, an outsider in 20; or what the suite says. It depends on the suite and the
/// number alone.
///
/// Sizes are uniform in their logarithm: between 1 and 10 times the usual one of the table, for a
/// ratio r between 0.5 and 4 times r - 1, and for what tells no size (a correlation time, the
/// length of gross errors) between 0.5 and 2 times. Faults are not drawn: no diagnosis names them.
/// Throws InvalidConfig for a scenario that is none, or that replays a trajectory.
BlindFlight DrawBlindFlight(const BlindSuite& suite, int number);

}  // namespace dn
