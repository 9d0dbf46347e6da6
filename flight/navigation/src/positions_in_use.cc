#include "positions_in_use.h"

#include <dn/median.h>
#include <dn/navigation/antenna_derivative.h>

#include <cmath>
#include <utility>

namespace dn::navigation_internal {

std::vector<PositionInUse> PositionsInUse(const FlightNetwork& network,
                                          const LinearizedNetwork& linearized) {
  std::vector<PositionInUse> positions;
  for (const GnssEdge& edge : network.gnss().edges()) {
    const auto rows = linearized.FindRows(edge.position);
    if (!rows) continue;
    const Eigen::Matrix3d R_m_enu =
        network.flight().frame.R_m_enu(network.trajectory().NodePose(edge.node).p_mb);
    const Eigen::MatrixXd J =
        AntennaDerivative(network, edge, linearized.EvaluateFactorAt(edge.position));
    positions.push_back(
        {linearized.t_s(edge.position), rows->first, std::sqrt(rows->weight) * J * R_m_enu});
  }
  return positions;
}

double MedianInterval(const std::vector<PositionInUse>& positions) {
  std::vector<double> steps_s;
  for (std::size_t k = 1; k < positions.size(); ++k) {
    steps_s.push_back(positions[k].t_s - positions[k - 1].t_s);
  }
  return Median(std::move(steps_s));
}

}  // namespace dn::navigation_internal
