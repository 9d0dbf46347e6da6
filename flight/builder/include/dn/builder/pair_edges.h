#pragma once

#include <dn/builder/inertial_edges.h>
#include <dn/builder/pair_factors.h>
#include <dn/factors/point_sensitivity.h>
#include <dn/factors/point_to_point.h>
#include <dn/lidar/pairs.h>

#include <Eigen/Core>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace dn {

/// A user-defined factor for point pairs that replaces MakePairFactor.
struct PairModel {
  /// Additional unknowns. The blocks of the factor are the nine blocks of PointToPoint, then these.
  std::vector<BlockId> blocks;
  /// Makes the factor of a pair. Called for every pair, and again whenever its increments are
  /// integrated again. The factor must also derive from PointPairFactor.
  std::function<std::shared_ptr<const FactorBase>(const Flight&, const PreparedPair&)> make;
};

/// A point pair and the nodes to which its ends are attached.
struct PairEdge {
  LidarPair pair;
  std::size_t node_i = 0;
  std::size_t node_j = 0;
  /// Indices of the inertial edges that condition the noise of the ends (IncrementConditioning).
  /// Absent: the white noise of the partial increments is negligible relative to the noise of the
  /// pair.
  std::optional<std::size_t> bridge_i = {};
  std::optional<std::size_t> bridge_j = {};
  FactorId id = -1;
};

/// One end of pair edge k.
struct PairEndIndex {
  std::size_t k = 0;
  PointPairFactor::End end = PointPairFactor::End::kI;
};

/// The edges of the point pairs. Each end is attached to the node before its epoch.
class PairEdges {
 public:
  PairEdges(const EdgeContext& context, const InertialEdges& inertial)
      : context_(context), inertial_(inertial) {}

  /// Sets the model of all pairs that are added later. Throws InvalidInput if effects of `estimate`
  /// act on pairs, and if the flight has several scanners.
  void SetModel(PairModel model);
  bool has_model() const { return model_.has_value(); }
  /// Returns the number of blocks that the model appends to every pair; 0 without a model.
  std::size_t num_own_blocks() const { return model_ ? model_->blocks.size() : 0; }

  /// Adds one factor per pair. A pair with both ends at one node, or with an IMU gap between an end
  /// and its node, is counted and left out. Throws InvalidInput if a model returns a factor that is
  /// not a PointPairFactor.
  void Add(const std::vector<LidarPair>& pairs);

  const std::vector<PairEdge>& edges() const { return edges_; }
  /// Returns the number of pairs left out because both ends attach to the same node.
  long within_one_node() const { return within_one_node_; }
  /// Returns the number of pairs left out because an IMU gap lies between an end and its node.
  long in_imu_gaps() const { return in_imu_gaps_; }

  /// Integrates the increments to all epochs again, at the present biases and this calibration.
  void Repreintegrate(const CalibrationState& calibration);

  /// Returns the difference p_i - p_j of the two points of edge k at the present unknowns, m, map
  /// axes. Throws InvalidInput if the factor was replaced by one that is not a PointPairFactor.
  Eigen::Vector3d Difference(std::size_t k) const;

  /// Returns the sensitivity of the residual to a shift of the point of one end, at the present
  /// unknowns. If the factor of the pair does not provide it, the factor of the library is used
  /// instead.
  PointSensitivity EndSensitivity(const PairEndIndex& end) const;

  /// Calls use(end, increments) for all ends. The increments go from the node to the epoch of the
  /// end under the given calibration, without noise, over the averaged samples `imu`
  /// (AverageSamples). Ends of different nodes are visited in parallel, so that `use` must be
  /// thread-safe.
  using UseEnd = std::function<void(const PairEndIndex&, const Preintegrated&)>;
  void ForEnds(const CalibrationState& calibration, const ImuData& imu, int threads,
               const UseEnd& use) const;

 private:
  using PartialIncrements = std::array<Preintegrated, 2>;  // to the epochs of both ends

  std::optional<PairEdge> Attach(const LidarPair& pair, double margin_s);
  void Bridge(PairEdge* edge) const;
  std::vector<BlockId> Blocks(const PairEdge& edge) const;
  std::vector<const double*> Values(std::size_t k) const;
  /// Integrates the increments of these edges at the present biases. Samples that several ends of a
  /// node share are integrated once.
  std::vector<PartialIncrements> Integrate(std::span<const PairEdge> edges,
                                           const PairCalibration& calibration) const;
  PreparedPair Prepare(const PairEdge& edge, const PairCalibration& calibration,
                       PartialIncrements increments) const;
  /// Returns the factor of a pair as it is without a model.
  std::shared_ptr<const FactorBase> LibraryFactor(const PairEdge& edge,
                                                  const PairCalibration& calibration,
                                                  PartialIncrements increments) const;
  std::shared_ptr<const FactorBase> ModelFactor(const PairEdge& edge,
                                                const PairCalibration& calibration,
                                                PartialIncrements increments) const;
  /// Calls work(edge, make) for all edges in their order. make() returns the factor of the edge and
  /// may be called once. A model is called from one thread only.
  template <class Work>
  void ForFactors(std::span<PairEdge> edges, const CalibrationState& calibration,
                  const Work& work) const;

  const EdgeContext& context_;
  const InertialEdges& inertial_;
  std::optional<PairModel> model_;
  std::vector<PairEdge> edges_;
  long within_one_node_ = 0;
  long in_imu_gaps_ = 0;
};

}  // namespace dn
