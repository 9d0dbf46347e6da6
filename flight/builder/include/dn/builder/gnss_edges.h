#pragma once

#include <dn/builder/edge_context.h>
#include <dn/builder/gnss_factors.h>

#include <memory>
#include <vector>

namespace dn {

/// The factors of one GNSS epoch.
struct GnssEdge {
  std::size_t node = 0;
  std::size_t epoch = 0;  ///< index into MapGnss::epochs of the flight
  FactorId position = -1;
  FactorId velocity = -1;  ///< -1: the velocity is not used
};

/// The edges of the GNSS epochs on nodes.
class GnssEdges {
 public:
  /// Attaches each epoch to the node at its time under the initial calibration (GnssEpochTime). An
  /// epoch without such a node is left out.
  explicit GnssEdges(const EdgeContext& context);

  const std::vector<GnssEdge>& edges() const { return edges_; }

  /// These two functions return the factor of an edge for another calibration at the present
  /// trajectory and biases. Its blocks are those of the edge, then the effects of the calibration
  /// in the order of GnssEffectIndices.
  std::shared_ptr<const FactorBase> PositionFactor(const GnssEdge& edge,
                                                   const CalibrationState& calibration) const;
  std::shared_ptr<const FactorBase> VelocityFactor(const GnssEdge& edge,
                                                   const CalibrationState& calibration) const;

  /// Makes the factors that depend on the motion of the antenna or its bank again, at the present
  /// trajectory and biases, and this calibration.
  void Rebuild(const CalibrationState& calibration);

 private:
  void Add(std::size_t epoch, std::size_t node, const CalibrationState& calibration);
  const MapGnssEpoch& Epoch(const GnssEdge& edge) const;
  GnssEdgeInput Input(const GnssEdge& edge) const;

  const EdgeContext& context_;
  std::vector<GnssEdge> edges_;
};

}  // namespace dn
