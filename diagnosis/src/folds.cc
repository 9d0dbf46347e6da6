#include "folds.h"

#include <dn/lidar/mounting.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace dn::diagnosis_internal {
namespace {

using Eigen::Vector2d;

constexpr double kOutageS = 30.0;
constexpr int kOutageSpacing = 6;  // from the start of one outage to the next, in outage lengths
constexpr std::size_t kFewestPairsOfTile = 12;

/// Returns the ground position of each pair from the node before it, accurate to some tens of
/// metres.
std::vector<Vector2d> PairGroundPositions(const FlightNetwork& network) {
  const Mounting& mounting = network.flight().config.lidar->mounting;
  std::vector<Vector2d> ground_m;
  for (const PairEdge& edge : network.pairs().edges()) {
    const MapPose pose = network.trajectory().NodePose(edge.node_i);
    ground_m.emplace_back(Georeference(pose, mounting, edge.pair.u_i_s).head<2>());
  }
  return ground_m;
}

/// Splits places into tiles with equal numbers of places, each time across the longer side.
class Tiles {
 public:
  Tiles(const std::vector<Vector2d>& places_m, int count) : places_m_(places_m) {
    std::vector<std::size_t> all(places_m.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    Split(std::move(all), count);
  }

  const std::vector<std::vector<std::size_t>>& tiles() const { return tiles_; }

 private:
  int LongerSide(const std::vector<std::size_t>& of) const {
    Vector2d low = places_m_[of[0]], high = low;
    for (const std::size_t k : of) {
      low = low.cwiseMin(places_m_[k]);
      high = high.cwiseMax(places_m_[k]);
    }
    return high.x() - low.x() >= high.y() - low.y() ? 0 : 1;
  }

  void Split(std::vector<std::size_t> of, int count) {
    if (count <= 1) {
      tiles_.push_back(std::move(of));
      return;
    }
    const int side = LongerSide(of);
    std::stable_sort(of.begin(), of.end(), [&](std::size_t a, std::size_t b) {
      return places_m_[a][side] < places_m_[b][side];
    });
    const int of_first = count / 2;
    const auto middle =
        of.begin() + static_cast<std::ptrdiff_t>(of.size() * static_cast<std::size_t>(of_first) /
                                                 static_cast<std::size_t>(count));
    Split({of.begin(), middle}, of_first);
    Split({middle, of.end()}, count - of_first);
  }

  const std::vector<Vector2d>& places_m_;
  std::vector<std::vector<std::size_t>> tiles_;
};

void AddTiles(const FlightNetwork& network, int count, std::vector<Fold>* folds) {
  const std::size_t pairs = network.pairs().edges().size();
  const int tiles = std::min(count, static_cast<int>(pairs / kFewestPairsOfTile));
  if (tiles < 2) return;
  const std::vector<Vector2d> ground_m = PairGroundPositions(network);
  const Tiles split(ground_m, tiles);
  for (const std::vector<std::size_t>& tile : split.tiles()) {
    Fold fold;
    for (const std::size_t k : tile) {
      const LidarPair& pair = network.pairs().edges()[k].pair;
      fold.pairs_t_s.emplace_back(pair.t_i_s, pair.t_j_s);
    }
    folds->push_back(std::move(fold));
  }
}

void AddOutages(const FlightNetwork& network, int count, std::vector<Fold>* folds) {
  const double begin_s = network.trajectory().node_times().front();
  std::vector<Fold> outages(static_cast<std::size_t>(std::min(count, kOutageSpacing)));
  for (const GnssEdge& edge : network.gnss().edges()) {
    const double t_s = network.flight().gnss->epochs[edge.epoch].t_s;
    const int at = static_cast<int>((t_s - begin_s) / kOutageS) % kOutageSpacing;
    for (std::size_t k = 0; k < outages.size(); ++k) {
      if (at != static_cast<int>(k) * kOutageSpacing / static_cast<int>(outages.size())) continue;
      outages[k].gnss_epochs.push_back(edge.epoch);
    }
  }
  for (Fold& fold : outages) {
    if (!fold.empty()) folds->push_back(std::move(fold));
  }
}

}  // namespace

std::vector<Fold> MakeFolds(const FlightNetwork& network, int num_per_kind) {
  std::vector<Fold> folds;
  AddTiles(network, num_per_kind, &folds);
  AddOutages(network, num_per_kind, &folds);
  return folds;
}

std::vector<FoldFactor> FindFoldFactors(const Fold& fold, const FlightNetwork& network) {
  std::map<std::pair<double, double>, FoldFactor> pairs;
  for (const PairEdge& edge : network.pairs().edges()) {
    pairs[{edge.pair.t_i_s, edge.pair.t_j_s}] = {edge.id, network.nodes()[edge.node_i].p_mb.id};
  }
  std::map<std::size_t, const GnssEdge*> epochs;
  for (const GnssEdge& edge : network.gnss().edges()) epochs[edge.epoch] = &edge;
  std::vector<FoldFactor> factors;
  for (const auto& t_s : fold.pairs_t_s) {
    const auto at = pairs.find(t_s);
    factors.push_back(at == pairs.end() ? FoldFactor{} : at->second);
  }
  for (const std::size_t epoch : fold.gnss_epochs) {
    const auto at = epochs.find(epoch);
    const bool there = at != epochs.end();
    const NodeBlocks* node = there ? &network.nodes()[at->second->node] : nullptr;
    factors.push_back(there ? FoldFactor{at->second->position, node->p_mb.id} : FoldFactor{});
    factors.push_back(there ? FoldFactor{at->second->velocity, node->v_m.id} : FoldFactor{});
  }
  return factors;
}

}  // namespace dn::diagnosis_internal
