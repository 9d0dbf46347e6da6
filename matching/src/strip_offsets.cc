#include "strip_offsets.h"

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "shift_trend.h"

namespace dn::matching_internal {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kFewestPairs = 4;

std::vector<PlacedShift> Shifts(const StripPairMatch& match, bool after) {
  std::vector<PlacedShift> shifts;
  for (const MatchedPair& pair : match.pairs) {
    shifts.push_back(
        {pair.p_j_m.head<2>(), after ? pair.after_m : pair.before_m(), *pair.pair.covariance_m2});
  }
  return shifts;
}

/// The shift of two strips over east and north.
struct Offset {
  ShiftTrend trend;
  Vector3d variance_m2 = Vector3d::Zero();  ///< at the centre
};

Offset FitOffset(const std::vector<PlacedShift>& shifts) {
  Offset offset{FitTrend(shifts), {}};
  offset.variance_m2 =
      ScatterAbout(offset.trend, shifts).cwiseAbs2() / static_cast<double>(shifts.size());
  return offset;
}

}  // namespace

Json OffsetJson(const StripPairMatch& match) {
  if (match.pairs.size() < kFewestPairs) return nullptr;
  const std::vector<PlacedShift> after = Shifts(match, true);
  const Offset offset = FitOffset(after);
  const ShiftTrend before = FitTrend(Shifts(match, false));
  return {{"shift_enu_m", ToJson(before.At(before.centre_en_m))},
          {"sigma_enu_m", ToJson(Vector3d(offset.variance_m2.cwiseSqrt()))},
          {"scatter_enu_m", ToJson(ScatterAbout(offset.trend, after))}};
}

Json LoopsJson(const MatchResult& result, const MatchSource& source) {
  std::map<std::pair<std::size_t, std::size_t>, Offset> offsets;
  for (const StripPairMatch& match : result.strip_pairs) {
    if (match.pairs.size() < kFewestPairs) continue;
    offsets[{match.i, match.j}] = FitOffset(Shifts(match, true));
  }
  Json loops = Json::array();
  for (const auto& [strips, first] : offsets) {
    for (std::size_t k = strips.second + 1; k < result.strips.size(); ++k) {
      const auto second = offsets.find({strips.second, k}), third = offsets.find({strips.first, k});
      if (second == offsets.end() || third == offsets.end()) continue;
      const Offset &b = second->second, &c = third->second;
      const Eigen::Vector2d at_m =
          (first.trend.centre_en_m + b.trend.centre_en_m + c.trend.centre_en_m) / 3.0;
      const Vector3d closure_m = first.trend.At(at_m) + b.trend.At(at_m) - c.trend.At(at_m);
      const Vector3d variance_m2 = first.variance_m2 + b.variance_m2 + c.variance_m2;
      loops.push_back({{"strips",
                        {source.strips()[strips.first].name, source.strips()[strips.second].name,
                         source.strips()[k].name}},
                       {"closure_enu_m", ToJson(closure_m)},
                       {"sigma_enu_m", ToJson(Vector3d(variance_m2.cwiseSqrt()))}});
    }
  }
  return loops;
}

}  // namespace dn::matching_internal
