#include "pair_columns.h"

#include <dn/builder/gravitation_jacobians.h>
#include <dn/factors/point_sensitivity.h>
#include <dn/files/scanners.h>

#include <array>
#include <mutex>
#include <optional>

namespace dn::diagnosis_internal {
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
        gravitation_(network.nodes().size()) {
    for (const std::size_t e : PairEffectIndices(calibration)) {
      values_.push_back(calibration.effects[e].value.data());
      num_values_ += calibration.effects[e].value.size();
    }
  }

  std::vector<Matrix3Xd> Run() {
    columns_.resize(network_.pairs().edges().size());
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const PairEdge& edge = network_.pairs().edges()[k];
      const FactorRecord& record = network_.net().factor(edge.id);
      if (!record.active || record.factor->residual_size() != 3) continue;
      columns_[k].setZero(3, num_values_);
      ComputeGravitationAt(edge.node_i);
      ComputeGravitationAt(edge.node_j);
    }
    network_.pairs().ForEnds(
        calibration_, means_, threads_,
        [&](const PairEndIndex& end, const Preintegrated& to) { Add(end, to); });
    return std::move(columns_);
  }

 private:
  void ComputeGravitationAt(std::size_t node) {
    if (!gravitation_[node]) {
      gravitation_[node] =
          GravitationJacobians(calibration_, network_.trajectory().NodePose(node).p_mb);
    }
  }

  void Add(const PairEndIndex& end, const Preintegrated& increments) {
    Matrix3Xd& columns = columns_[end.k];
    if (columns.cols() == 0) return;
    const PairEdge& edge = network_.pairs().edges()[end.k];
    const bool first = end.end == PointPairFactor::End::kI;
    const std::optional<std::size_t>& bridge = first ? edge.bridge_i : edge.bridge_j;
    const LaserShot shot = first ? ShotI(edge.pair) : ShotJ(edge.pair);
    const LidarReading reading =
        Corrected(lidar_, values_.data(), shot.tag_s, shot.u_s, shot.scanner, shot.beam);
    const auto scanner = static_cast<std::size_t>(shot.scanner);
    const PointSensitivity point = network_.pairs().EndSensitivity(end);
    Matrix3Xd end_columns = Matrix3Xd::Zero(3, columns.cols());
    AddEffectJacobians(point,
                       {reading, increments.J_effects, bridge ? &whole_[*bridge] : nullptr,
                        *gravitation_[first ? edge.node_i : edge.node_j]},
                       ScannerAt(network_.flight().config, scanner).mounting.R_bs_nominal,
                       end_columns);
    // The two ends of a pair may arrive in either order; a sum of two terms does not depend on it.
    const std::lock_guard lock(adding_[end.k % adding_.size()]);
    columns += end_columns;
  }

  const FlightNetwork& network_;
  const CalibrationState& calibration_;
  const ImuData& means_;
  const std::vector<Matrix3Xd>& whole_;
  int threads_;
  LidarEffects lidar_;
  // Values of the effects on pairs, those of the lidar first.
  std::vector<const double*> values_;
  Eigen::Index num_values_ = 0;
  std::vector<std::optional<std::vector<GravitationBasis>>> gravitation_;  // per node with pairs
  std::array<std::mutex, 64> adding_;
  std::vector<Matrix3Xd> columns_;
};

}  // namespace

std::vector<Matrix3Xd> PairColumns(const FlightNetwork& network,
                                   const CalibrationState& calibration, const ImuData& means,
                                   const std::vector<Matrix3Xd>& whole, int threads) {
  return Columns(network, calibration, means, whole, threads).Run();
}

}  // namespace dn::diagnosis_internal
