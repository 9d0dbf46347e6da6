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
  static const ScenarioWords<TerrainKind> words{
      {"built_up", TerrainKind::kBuiltUp}, {"mixed", TerrainKind::kMixed},
      {"natural", TerrainKind::kNatural},  {"mountain", TerrainKind::kMountain},
      {"flat", TerrainKind::kFlat},        {"forest", TerrainKind::kForest},
      {"orchard", TerrainKind::kOrchard},  {"town", TerrainKind::kTown},
      {"quarry", TerrainKind::kQuarry},    {"fields", TerrainKind::kFields}};
  return words;
}

inline const ScenarioWords<ScanPattern>& ScanPatternWords() {
  static const ScenarioWords<ScanPattern> words{{"line", ScanPattern::kLine},
                                                {"zigzag", ScanPattern::kZigzag},
                                                {"cone", ScanPattern::kCone},
                                                {"rotating", ScanPattern::kRotating}};
  return words;
}

inline const ScenarioWords<TurbulenceSpectrum>& TurbulenceWords() {
  static const ScenarioWords<TurbulenceSpectrum> words{{"smooth", TurbulenceSpectrum::kSmooth},
                                                       {"dryden", TurbulenceSpectrum::kDryden}};
  return words;
}

inline const ScenarioWords<ImuSampling>& SamplingWords() {
  static const ScenarioWords<ImuSampling> words{{"mean", ImuSampling::kMean},
                                                {"instantaneous", ImuSampling::kInstantaneous}};
  return words;
}

}  // namespace dn
