#include <dn/diagnosis/solution.h>
#include <dn/fleet/reduced_ties.h>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace dn {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Number of points whose covariance columns are in memory at a time.
constexpr std::size_t kPointsAtOnce = 20;

/// Returns the rows of some blocks, one below the other.
MatrixXd StackRows(const Marginals::Columns& columns, const std::vector<BlockId>& blocks) {
  MatrixXd stacked;
  for (const BlockId block : blocks) {
    const MatrixXd rows = columns.Rows(block);
    stacked.conservativeResize(stacked.rows() + rows.rows(), rows.cols());
    stacked.bottomRows(rows.rows()) = rows;
  }
  return stacked;
}

/// Returns the moments of the network's own blocks, map axes. `cross` is with `unknowns`.
TieMoments NetworkMoments(const Solution& solution, const std::vector<BlockId>& ties,
                          const std::vector<BlockId>& unknowns) {
  const Network& net = solution.network().net();
  Index width = 0;
  for (const BlockId unknown : unknowns) width += net.block(unknown).kind.tangent_size;
  const auto size = 3 * static_cast<Index>(ties.size());
  TieMoments moments{VectorXd(size), MatrixXd(size, size), MatrixXd(size, width)};
  for (std::size_t first = 0; first < ties.size(); first += kPointsAtOnce) {
    const std::size_t last = std::min(first + kPointsAtOnce, ties.size());
    const std::vector<BlockId> some(ties.begin() + static_cast<std::ptrdiff_t>(first),
                                    ties.begin() + static_cast<std::ptrdiff_t>(last));
    const Marginals::Columns columns = solution.marginals().SolveColumns(some);
    const auto at = Eigen::seqN(3 * static_cast<Index>(first), 3 * static_cast<Index>(some.size()));
    moments.covariance_m2(Eigen::all, at) = StackRows(columns, ties);
    moments.cross(at, Eigen::all) = StackRows(columns, unknowns).transpose();
  }
  for (std::size_t k = 0; k < ties.size(); ++k) {
    moments.mean_e_m.segment<3>(3 * static_cast<Index>(k)) =
        Eigen::Map<const Vector3d>(net.block(ties[k]).value.get());
  }
  return moments;
}

/// Adds what the unmodelled effects change, and appends them to the unknowns.
void AddEffects(const EffectPosterior& posterior, const std::vector<Index>& rows,
                TieMoments* moments) {
  const auto points = Eigen::seqN(posterior.first_tie, moments->mean_e_m.size());
  moments->mean_e_m += posterior.change(points);
  moments->covariance_m2 += posterior.added(points, points);
  MatrixXd cross(moments->mean_e_m.size(), moments->cross.cols() + posterior.cross.cols());
  cross << moments->cross + posterior.added(points, rows), posterior.cross(points, Eigen::all);
  moments->cross = std::move(cross);
}

/// Turns moments from map axes into ECEF.
void TurnToEcef(const LocalFrame& frame, TieMoments* moments) {
  const Matrix3d R_em = frame.R_me().transpose();
  const Index size = moments->mean_e_m.size();
  for (Index row = 0; row < size; row += 3) {
    const Vector3d p_m = moments->mean_e_m.segment<3>(row) + frame.r0_m();
    moments->mean_e_m.segment<3>(row) = R_em * p_m;
    moments->cross.middleRows<3>(row) = (R_em * moments->cross.middleRows<3>(row)).eval();
    moments->covariance_m2.middleRows<3>(row) =
        (R_em * moments->covariance_m2.middleRows<3>(row)).eval();
  }
  for (Index column = 0; column < size; column += 3) {
    moments->covariance_m2.middleCols<3>(column) =
        (moments->covariance_m2.middleCols<3>(column) * R_em.transpose()).eval();
  }
}

}  // namespace

std::optional<ReducedTies> ReduceTies(const Solution& solution,
                                      const std::vector<BlockId>& unknowns,
                                      const std::vector<Index>& rows,
                                      const EffectPosterior* posterior) {
  const FlightNetwork& network = solution.network();
  if (network.ties().points().empty()) return std::nullopt;
  const TieData& data = *network.flight().ties;
  const LocalFrame& frame = network.flight().frame;
  const Matrix3d R_em = frame.R_me().transpose();
  ReducedTies ties;
  std::vector<BlockId> blocks;
  for (const ControlNode& node : network.ties().points()) {
    blocks.push_back(node.deviation);
    ties.names.push_back(data.points.points[node.point].name);
    std::optional<Matrix3d> noise_m2 = data.covariance_m2[node.point];
    if (noise_m2) noise_m2 = R_em * *noise_m2 * R_em.transpose();
    ties.noise_m2.push_back(noise_m2);
  }
  ties.moments = NetworkMoments(solution, blocks, unknowns);
  ties.as_modelled = ties.moments;
  ties.as_modelled.cross = ties.moments.cross.leftCols<3>().eval();
  if (posterior != nullptr) AddEffects(*posterior, rows, &ties.moments);
  TurnToEcef(frame, &ties.moments);
  TurnToEcef(frame, &ties.as_modelled);
  return ties;
}

}  // namespace dn
