#include "pair_columns.h"

#include <dn/factors/point_sensitivity.h>

#include <array>
#include <mutex>
#include <optional>

namespace dn::internal {
namespace {

using Eigen::Matrix3Xd;

class Columns {
 public:
  Columns(const FlightNetwork& network, const CalibrationState& calibration, const ImuData& means,
          const std::vector<Matrix3Xd>& whole, int threads)
      : network_(network),
        calibration_(calibration),
        means_(means),
        whole_(whole),
        threads_(threads),
        lidar_(PairCalibration(calibration).lidar()),
        attraction_(network.nodes.size()) {
    for (const std::size_t e : EffectsOfPairs(calibration)) {
      values_.push_back(calibration.effects[e].value.data());
      num_values_ += calibration.effects[e].value.size();
    }
  }

  std::vector<Matrix3Xd> Run() {
    columns_.resize(network_.pair_edges.size());
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const FlightNetwork::PairEdge& edge = network_.pair_edges[k];
      const FactorRecord& record = network_.net.factor(edge.id);
      if (!record.active || record.factor->residual_size() != 3) continue;
      columns_[k].setZero(3, kColumnOfPairEffects + num_values_);
      AttractAt(edge.node_i);
      AttractAt(edge.node_j);
    }
    network_.ForPairEnds(
        calibration_, means_, threads_,
        [&](const FlightNetwork::EndOfPair& end, const Preintegrated& to) { Add(end, to); });
    return std::move(columns_);
  }

 private:
  void AttractAt(std::size_t node) {
    if (!attraction_[node]) {
      attraction_[node] = AttractionBases(calibration_, network_.NodePose(node).p_mb);
    }
  }

  void Add(const FlightNetwork::EndOfPair& end, const Preintegrated& increments) {
    Matrix3Xd& columns = columns_[end.k];
    if (columns.cols() == 0) return;
    const FlightNetwork::PairEdge& edge = network_.pair_edges[end.k];
    const bool first = end.end == PointPairFactor::End::kI;
    const std::optional<std::size_t>& bridge = first ? edge.bridge_i : edge.bridge_j;
    const LidarReading reading =
        Corrected(lidar_, values_.data(), first ? edge.pair.t_i_s : edge.pair.t_j_s,
                  first ? edge.pair.u_i_s : edge.pair.u_j_s);
    const PointSensitivity point = network_.SensitivityOfEnd(end);
    Matrix3Xd of_end = Matrix3Xd::Zero(3, columns.cols());
    of_end.middleCols<3>(kColumnOfLeverArm) = point.lever_arm;
    of_end.col(kColumnOfTimeOffset) = point.delay;
    AddByEffects(point,
                 {reading, increments.J_effects, bridge ? &whole_[*bridge] : nullptr,
                  *attraction_[first ? edge.node_i : edge.node_j]},
                 network_.flight().config.lidar->mounting.R_bs_nominal,
                 of_end.rightCols(num_values_));
    // Of two terms, which may come in either order.
    const std::lock_guard lock(adding_[end.k % adding_.size()]);
    columns += of_end;
  }

  const FlightNetwork& network_;
  const CalibrationState& calibration_;
  const ImuData& means_;
  const std::vector<Matrix3Xd>& whole_;
  int threads_;
  LidarEffects lidar_;
  std::vector<const double*> values_;  // of the effects on pairs, those of the lidar first
  Eigen::Index num_values_ = 0;
  std::vector<std::optional<std::vector<AttractionBasis>>> attraction_;  // of nodes with pairs
  std::array<std::mutex, 64> adding_;
  std::vector<Matrix3Xd> columns_;
};

}  // namespace

std::vector<Matrix3Xd> PairColumns(const FlightNetwork& network,
                                   const CalibrationState& calibration, const ImuData& means,
                                   const std::vector<Matrix3Xd>& whole, int threads) {
  return Columns(network, calibration, means, whole, threads).Run();
}

}  // namespace dn::internal
