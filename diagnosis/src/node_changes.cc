#include "node_changes.h"

#include <dn/adjustment/trajectory_sigma.h>
#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace dn {

void NodeChange::MovePose(MapPose* pose) const {
  pose->p_mb += position_m;
  pose->v_m += velocity_mps;
  pose->q_mb = pose->q_mb * Exp(attitude_rad);
}

namespace diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Columns of effects that are solved for together; bounds the memory of the dense rows.
constexpr Index kColumnsAtOnce = 24;
// Nodes whose shifts are multiplied together, and rows of each.
constexpr std::size_t kNodesAtOnce = 32;
constexpr Index kNodeRows = 15;

/// Returns L of some components of the score, in the scaling of the network's rows.
MatrixXd DenseColumns(const LinearizedNetwork& linearized, const Library& library,
                      const std::vector<Index>& components) {
  MatrixXd L = MatrixXd::Zero(linearized.rows(), static_cast<Index>(components.size()));
  Index first = 0;
  for (const EffectModel& block : library.blocks) {
    const Index past = first + (block.empty() ? 0 : block.front().L.cols());
    for (std::size_t k = 0; k < components.size(); ++k) {
      if (components[k] < first || components[k] >= past) continue;
      for (const EffectPart& part : block) {
        const auto rows = linearized.FindRows(part.factor);
        if (!rows) continue;
        L.col(static_cast<Index>(k)).segment(rows->first, rows->count) =
            std::sqrt(rows->weight) * part.L.col(components[k] - first);
      }
    }
    first = past;
  }
  return L;
}

/// Returns the shift of all unknowns of the network per unit of each unmodelled component.
MatrixXd SolveShifts(const Marginals& marginals, const Library& library,
                     const std::vector<Index>& components) {
  const LinearizedNetwork& linearized = marginals.linearized();
  MatrixXd shift(linearized.parameters(), static_cast<Index>(components.size()));
  for (Index k = 0; k < shift.cols(); k += kColumnsAtOnce) {
    const Index count = std::min(kColumnsAtOnce, shift.cols() - k);
    const std::vector<Index> some(components.begin() + k, components.begin() + k + count);
    shift.middleCols(k, count) =
        marginals.Solve(linearized.TransposeTimes(DenseColumns(linearized, library, some)));
  }
  return shift;
}

/// The shifts of all unknowns of a network, by the components of the unmodelled effects.
struct NetworkShifts {
  const TrajectoryGraph& trajectory;
  const LinearizedNetwork& linearized;
  const MatrixXd& shift;

  /// Returns the shift of a block; zero if it is constant.
  MatrixXd Rows(BlockId block) const {
    const int first = linearized.FirstColumn(block);
    if (first < 0) return MatrixXd::Zero(3, shift.cols());
    return shift.middleRows<3>(first);
  }

  /// Returns the shift of a total bias at t_s.
  MatrixXd BiasRows(const std::vector<ProcessChain>& chains, double t_s) const {
    MatrixXd rows = MatrixXd::Zero(3, shift.cols());
    for (const ProcessChain& chain : chains) rows += Rows(chain.At(t_s).id);
    return rows;
  }

  /// Returns the shifts of position, velocity, attitude and the biases of gyros and accelerometers
  /// at some nodes.
  MatrixXd NodeRows(std::span<const NodeBlocks> nodes) const {
    MatrixXd rows(kNodeRows * static_cast<Index>(nodes.size()), shift.cols());
    Index row = 0;
    for (const NodeBlocks& node : nodes) {
      rows.middleRows<kNodeRows>(row) << Rows(node.p_mb.id), Rows(node.v_m.id), Rows(node.q_mb.id),
          BiasRows(trajectory.gyro_bias(), node.t_s), BiasRows(trajectory.accel_bias(), node.t_s);
      row += kNodeRows;
    }
    return rows;
  }
};

/// `mean` and `gain` have the rows of the node: the mean shift, and a root of its covariance.
NodeChange MakeChange(double t_s, const NodeAxes& axes, const Eigen::VectorXd& mean,
                      const MatrixXd& gain) {
  const MatrixXd position = gain.topRows<3>(), velocity = gain.middleRows<3>(3),
                 attitude = gain.middleRows<3>(6), gyro = gain.middleRows<3>(9),
                 accel = gain.bottomRows<3>();
  const auto variance = [](const MatrixXd& part) {
    return Eigen::Vector3d(part.rowwise().squaredNorm());
  };
  NodeChange change;
  change.t_s = t_s;
  change.position_m = -mean.head<3>();
  change.velocity_mps = -mean.segment<3>(3);
  change.attitude_rad = -mean.segment<3>(6);
  change.gyro_bias_radps = -mean.segment<3>(9);
  change.accel_bias_mps2 = -mean.tail<3>();
  change.velocity_variance_enu = variance(axes.R_enu_m * velocity);
  change.rph_variance_rad2 = variance(axes.rph_from_body * attitude);
  change.position_covariance_m2 = position * position.transpose();
  change.velocity_covariance = velocity * velocity.transpose();
  change.gyro_bias_covariance = gyro * gyro.transpose();
  change.accel_bias_covariance = accel * accel.transpose();
  change.pose_root.resize(6, gain.cols());
  change.pose_root << axes.R_enu_m * position, attitude;
  return change;
}

}  // namespace

std::vector<NodeChange> NodeChanges(const FlightNetwork& network, const Marginals& marginals,
                                    const Library& library, const UnmodelledUnknowns& unmodelled) {
  const MatrixXd shift = SolveShifts(marginals, library, unmodelled.components());
  const Eigen::VectorXd estimate = unmodelled.estimate()(unmodelled.components());
  const MatrixXd root = unmodelled.PosteriorRoot();
  const NetworkShifts shifts{network.trajectory(), marginals.linearized(), shift};
  const std::span<const NodeBlocks> nodes(network.nodes());
  std::vector<NodeChange> changes;
  for (std::size_t first = 0; first < nodes.size(); first += kNodesAtOnce) {
    const auto some = nodes.subspan(first, std::min(kNodesAtOnce, nodes.size() - first));
    const MatrixXd rows = shifts.NodeRows(some);
    const Eigen::VectorXd mean = rows * estimate;
    const MatrixXd gain = rows * root;
    for (std::size_t k = 0; k < some.size(); ++k) {
      const Index row = kNodeRows * static_cast<Index>(k);
      changes.push_back(MakeChange(some[k].t_s, FindNodeAxes(network, first + k),
                                   mean.segment(row, kNodeRows), gain.middleRows(row, kNodeRows)));
    }
  }
  return changes;
}

}  // namespace diagnosis_internal
}  // namespace dn
