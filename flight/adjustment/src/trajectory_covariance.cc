#include <dn/adjustment/trajectory_covariance.h>
#include <dn/builder/node_grid.h>

#include <algorithm>
#include <cmath>

#include "turn_position.h"

namespace dn {
namespace {

constexpr std::size_t kMaxCovarianceEpochs = 64;
constexpr std::size_t kMaxCovarianceStrips = kMaxCovarianceEpochs / 2;

struct StripNode {
  std::size_t node;
  int strip;
};

std::vector<StripNode> Spread(const std::vector<double>& node_t_s,
                              const std::vector<StripInterval>& strips, double spacing_s) {
  std::vector<StripNode> chosen;
  for (std::size_t s = 0; s < strips.size(); ++s) {
    const double length_s = strips[s].t1_s - strips[s].t0_s;
    const int steps = std::max(1, static_cast<int>(std::lround(length_s / spacing_s)));
    for (int k = 0; k <= steps; ++k) {
      const std::size_t node = NodeNear(node_t_s, strips[s].t0_s + k * length_s / steps);
      if (chosen.empty() || node > chosen.back().node)
        chosen.push_back({node, static_cast<int>(s)});
    }
  }
  return chosen;
}

std::vector<StripNode> Choose(const std::vector<double>& node_t_s,
                              const std::vector<StripInterval>& strips) {
  constexpr double kGrowth = 1.1;
  double spacing_s = 1.0;
  std::vector<StripNode> chosen = Spread(node_t_s, strips, spacing_s);
  while (chosen.size() > kMaxCovarianceEpochs) {
    spacing_s *= kGrowth;
    chosen = Spread(node_t_s, strips, spacing_s);
  }
  return chosen;
}

}  // namespace

TrajectoryCovariance ExtractTrajectoryCovariance(const Adjustment& adjustment,
                                                 const Marginals& marginals,
                                                 const std::vector<StripInterval>& strips) {
  TrajectoryCovariance out;
  if (strips.empty() || strips.size() > kMaxCovarianceStrips) return out;
  const FlightNetwork& network = *adjustment.network;
  const std::vector<StripNode> chosen = Choose(network.trajectory().node_times(), strips);
  const auto T = static_cast<Eigen::Index>(chosen.size());
  out.covariance.resize(6 * T, 6 * T);
  for (Eigen::Index j = 0; j < T; ++j) {
    const StripNode& at = chosen[static_cast<std::size_t>(j)];
    const NodeBlocks& node = network.nodes()[at.node];
    out.t_s.push_back(node.t_s);
    out.strip.push_back(at.strip);
    const Marginals::Columns columns = marginals.SolveColumns({node.p_mb.id, node.q_mb.id});
    for (Eigen::Index i = 0; i < T; ++i) {
      const NodeBlocks& other = network.nodes()[chosen[static_cast<std::size_t>(i)].node];
      out.covariance.block<6, 6>(6 * i, 6 * j) << columns.Rows(other.p_mb.id),
          columns.Rows(other.q_mb.id);
    }
  }
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const Eigen::Vector3d p_mb = network.trajectory().NodePose(chosen[k].node).p_mb;
    adjustment_internal::RotatePosition(network.flight().frame.R_m_enu(p_mb).transpose(), k,
                                        &out.covariance);
  }
  out.covariance = (0.5 * (out.covariance + out.covariance.transpose())).eval();
  return out;
}

}  // namespace dn
