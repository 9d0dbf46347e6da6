#include <dn/matching/loop_redundancy.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace dn {
namespace {

using Eigen::Vector2d;
using StripPair = std::pair<std::size_t, std::size_t>;

/// The cell of a pair on the ground.
struct Cell {
  Vector2d centre_en_m;
  double radius_m;
  StripPair strips;
};

/// Finds the cells near a place.
class CellMap {
 public:
  explicit CellMap(std::vector<Cell> cells) : cells_(std::move(cells)) {
    for (const Cell& cell : cells_) side_m_ = std::max(side_m_, 2.0 * cell.radius_m);
    for (std::size_t k = 0; k < cells_.size(); ++k) map_[Index(cells_[k].centre_en_m)].push_back(k);
  }

  /// Returns the strip pairs with cells that overlap this one.
  std::set<StripPair> StripPairsAt(const Cell& cell) const {
    std::set<StripPair> found;
    const auto [x, y] = Index(cell.centre_en_m);
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        const auto at = map_.find({x + dx, y + dy});
        if (at == map_.end()) continue;
        for (const std::size_t k : at->second) {
          const Vector2d apart_m = (cells_[k].centre_en_m - cell.centre_en_m).cwiseAbs();
          if (apart_m.maxCoeff() < cells_[k].radius_m + cell.radius_m) {
            found.insert(cells_[k].strips);
          }
        }
      }
    }
    return found;
  }

 private:
  std::pair<std::int64_t, std::int64_t> Index(const Vector2d& p_en_m) const {
    return {static_cast<std::int64_t>(std::floor(p_en_m.x() / side_m_)),
            static_cast<std::int64_t>(std::floor(p_en_m.y() / side_m_))};
  }

  std::vector<Cell> cells_;
  double side_m_ = 1e-3;
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>> map_;
};

/// Returns the number of strip pairs that are not implied by others: strips minus connected sets.
std::size_t NumIndependent(const std::set<StripPair>& strip_pairs) {
  std::map<std::size_t, std::size_t> set_of;
  std::size_t independent = 0;
  for (const auto& [i, j] : strip_pairs) {
    const std::size_t set_i = set_of.try_emplace(i, i).first->second;
    const std::size_t set_j = set_of.try_emplace(j, j).first->second;
    if (set_i == set_j) continue;
    ++independent;
    for (auto& [strip, set] : set_of) {
      if (set == set_j) set = set_i;
    }
  }
  return independent;
}

/// Returns the number of strip pairs divided by that of the independent ones.
double Redundancy(const std::set<StripPair>& strip_pairs) {
  return static_cast<double>(strip_pairs.size()) / static_cast<double>(NumIndependent(strip_pairs));
}

/// Returns the cell of a pair or of a surface.
template <class Match>
Cell MakeCell(const StripPairMatch& strips, const Match& match) {
  return {match.p_j_m.template head<2>(), match.radius_m, {strips.i, strips.j}};
}

}  // namespace

void InflateLoops(MatchResult* result) {
  std::vector<Cell> cells;
  for (const StripPairMatch& match : result->strip_pairs) {
    for (const MatchedPair& pair : match.pairs) cells.push_back(MakeCell(match, pair));
    for (const MatchedSurface& surface : match.surfaces) cells.push_back(MakeCell(match, surface));
  }
  const CellMap map(std::move(cells));
  for (StripPairMatch& match : result->strip_pairs) {
    for (MatchedPair& pair : match.pairs) {
      *pair.pair.covariance_m2 *= Redundancy(map.StripPairsAt(MakeCell(match, pair)));
    }
    for (MatchedSurface& surface : match.surfaces) {
      surface.pair.sigma_m *= std::sqrt(Redundancy(map.StripPairsAt(MakeCell(match, surface))));
    }
  }
}

}  // namespace dn
