#include "node_changes.h"

#include <dn/adjustment/trajectory_sigma.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Columns of effects that are solved for together; bounds the memory of the dense rows.
constexpr Index kColumnsAtOnce = 8;

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

}  // namespace

std::vector<NodeChange> NodeChanges(const FlightNetwork& network, const Marginals& marginals,
                                    const Library& library, const UnmodelledUnknowns& unmodelled) {
  const MatrixXd shift = SolveShifts(marginals, library, unmodelled.components());
  const Eigen::VectorXd estimate = unmodelled.estimate()(unmodelled.components());
  const MatrixXd root = unmodelled.PosteriorRoot();
  std::vector<NodeChange> changes;
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    const NodeBlocks& node = network.nodes()[k];
    const auto rows = [&](BlockId block) {
      const int first = marginals.linearized().FirstColumn(block);
      return first < 0 ? MatrixXd(MatrixXd::Zero(3, shift.cols()))
                       : MatrixXd(shift.middleRows<3>(first));
    };
    const MatrixXd p = rows(node.p_mb.id), v = rows(node.v_m.id), q = rows(node.q_mb.id);
    const NodeAxes axes = FindNodeAxes(network, k);
    const auto variance = [](const MatrixXd& gain) {
      return Eigen::Vector3d(gain.rowwise().squaredNorm());
    };
    const MatrixXd position = axes.R_enu_m * p * root, attitude = q * root;
    NodeChange change;
    change.t_s = node.t_s;
    change.position_m = -p * estimate;
    change.velocity_mps = -v * estimate;
    change.attitude_rad = -q * estimate;
    change.velocity_variance_enu = variance(axes.R_enu_m * v * root);
    change.rph_variance_rad2 = variance(axes.rph_from_body * attitude);
    change.position_covariance_m2 = (p * root) * (p * root).transpose();
    change.velocity_covariance = (v * root) * (v * root).transpose();
    change.pose_root.resize(6, root.cols());
    change.pose_root << position, attitude;
    changes.push_back(change);
  }
  return changes;
}

}  // namespace dn::diagnosis_internal
