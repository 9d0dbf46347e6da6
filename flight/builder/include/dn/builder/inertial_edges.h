#pragma once

#include <dn/builder/edge_context.h>
#include <dn/factors/preintegrated_inertial.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

namespace dn {

/// An inertial edge between a node and the next one.
struct InertialEdge {
  std::size_t node_i = 0;
  FactorId id = -1;
};

/// The preintegrated edges between neighbouring nodes.
class InertialEdges {
 public:
  /// Adds an edge for every interval between nodes without a gap in the inertial data.
  explicit InertialEdges(const EdgeContext& context);

  /// Returns the edges in the order of their nodes.
  const std::vector<InertialEdge>& edges() const { return edges_; }

  /// Returns the index of the edge that starts at a node; nullopt at a gap.
  std::optional<std::size_t> FindEdge(std::size_t node) const;

  /// Returns the factor of an edge for another calibration at the present trajectory and biases.
  /// Its blocks are those of the edge, then the effects of the calibration in the order of
  /// InertialEffectIndices.
  std::shared_ptr<const PreintegratedInertial> Factor(const InertialEdge& edge,
                                                      const CalibrationState& calibration) const;

  /// Returns the factor of Factor() without integrating the increments again: they are those in
  /// use. Only their derivatives with respect to the effects are integrated, over the averaged
  /// samples `imu` (AverageSamples).
  std::shared_ptr<const PreintegratedInertial> FactorByMeans(const InertialEdge& edge,
                                                             const CalibrationState& calibration,
                                                             const ImuData& imu) const;

  /// Returns the factor of an edge in the network. If the caller has replaced it, returns that of
  /// the last preintegration.
  std::shared_ptr<const PreintegratedInertial> FactorInUse(const InertialEdge& edge) const;

  /// Integrates all increments again at the present biases and this calibration, and moves the
  /// expansion point of gravity to the present positions.
  void Repreintegrate(const CalibrationState& calibration);

  /// Returns the largest change of a bias or effect since the last preintegration. The units are 30
  /// deg/h (gyro), 5 mg (accelerometer) and ten typical sizes (effects). At a hundredth of such a
  /// unit, the error of the first-order correction is far below the noise of every increment.
  double BiasChange() const;

 private:
  void SetLinearisation(const CalibrationState& calibration);
  std::shared_ptr<const PreintegratedInertial> FactorOn(const Preintegrated& increments,
                                                        const InertialEdge& edge,
                                                        const CalibrationState& calibration) const;
  /// Returns the factors of all edges at the linearisation.
  std::vector<std::shared_ptr<const PreintegratedInertial>> Factors() const;

  const EdgeContext& context_;
  std::vector<InertialEdge> edges_;
  CalibrationState linearised_;
  std::vector<ImuCorrection> linearised_biases_;  // one per edge
};

}  // namespace dn
