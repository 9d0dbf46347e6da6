#include "pair_clusters.h"

#include <dn/factors/point_to_point.h>
#include <dn/files/strip_at.h>
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>
#include <tuple>

namespace dn::diagnosis_internal {
namespace {

/// The rows of one pair, its strips and its first point on the ground.
struct PlacedPair {
  LinearizedNetwork::FactorRows rows;
  const StripInterval *strip_i, *strip_j;
  Eigen::Vector3d point_m;
};

/// Returns the first point of a pair, m, map axes; nullopt if its factor gives no points.
std::optional<Eigen::Vector3d> GroundPoint(const Network& net, FactorId id) {
  const FactorRecord& record = net.factor(id);
  const auto* points = dynamic_cast<const PointPairFactor*>(record.factor.get());
  if (points == nullptr) return std::nullopt;
  std::vector<const double*> x;
  for (const BlockId block : record.blocks) x.push_back(net.block(block).value.get());
  return points->Points(x.data()).first;
}

std::vector<PlacedPair> PlacePairs(const FlightNetwork& network,
                                   const LinearizedNetwork& linearized,
                                   const std::vector<StripInterval>& strips) {
  std::vector<PlacedPair> placed;
  for (const PairEdge& edge : network.pairs().edges()) {
    const auto rows = linearized.FindRows(edge.id);
    if (!rows) continue;
    const auto point_m = GroundPoint(network.net(), edge.id);
    if (!point_m) continue;
    placed.push_back(
        {*rows, StripAt(strips, edge.pair.t_i_s), StripAt(strips, edge.pair.t_j_s), *point_m});
  }
  return placed;
}

ResidualForm MakeForm(const std::vector<PlacedPair>& pairs, Eigen::Index num_rows, int axis,
                      const std::string& channel, double length_m) {
  using Tile = std::tuple<const StripInterval*, const StripInterval*, long, long>;
  ResidualForm form{fmt::format("{}, over {:g} m", channel, length_m), channel, {}, 0, {}};
  form.label.assign(static_cast<std::size_t>(num_rows), -1);
  std::map<Tile, int> label;
  for (const PlacedPair& pair : pairs) {
    const auto number = [&](double x_m) { return std::lround(std::floor(x_m / length_m)); };
    const Tile tile{pair.strip_i, pair.strip_j, number(pair.point_m.x()), number(pair.point_m.y())};
    form.label[static_cast<std::size_t>(pair.rows.first) + static_cast<std::size_t>(axis)] =
        label.try_emplace(tile, static_cast<int>(label.size())).first->second;
  }
  form.labels = static_cast<int>(label.size());
  return form;
}

}  // namespace

std::vector<ResidualForm> PairClusters(const FlightNetwork& network,
                                       const LinearizedNetwork& linearized,
                                       const std::vector<double>& lengths_m) {
  const std::vector<StripInterval> strips = FindStrips(network.flight());
  const std::vector<PlacedPair> pairs = PlacePairs(network, linearized, strips);
  std::vector<ResidualForm> forms;
  if (pairs.empty()) return forms;
  const FactorGroup& group = linearized.group(pairs.front().rows.factor);
  for (int axis = 0; axis < pairs.front().rows.count; ++axis) {
    const std::string channel = group.Channel(axis) + " " + group.Axis(axis);
    for (const double length_m : lengths_m) {
      forms.push_back(MakeForm(pairs, linearized.rows(), axis, channel, length_m));
    }
  }
  return forms;
}

}  // namespace dn::diagnosis_internal
