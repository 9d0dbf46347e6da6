#pragma once

#include <dn/sim/scenario.h>

#include <string>
#include <utility>
#include <vector>

namespace dn {

/// Words of a scenario file with their meanings.
template <class T>
using ScenarioWords = std::vector<std::pair<std::string, T>>;

inline const ScenarioWords<TerrainKind>& TerrainWords() {
  static const ScenarioWords<TerrainKind> words{{"built_up", TerrainKind::kBuiltUp},
                                                {"mixed", TerrainKind::kMixed},
                                                {"natural", TerrainKind::kNatural},
                                                {"mountain", TerrainKind::kMountain},
                                                {"flat", TerrainKind::kFlat}};
  return words;
}

inline const ScenarioWords<ScanPattern>& ScanPatternWords() {
  static const ScenarioWords<ScanPattern> words{{"line", ScanPattern::kLine},
                                                {"cone", ScanPattern::kCone}};
  return words;
}

}  // namespace dn
