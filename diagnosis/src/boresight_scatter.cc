#include "boresight_scatter.h"

#include <dn/error.h>
#include <dn/files/strip_at.h>
#include <dn/parallel.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace dn::diagnosis_internal {
namespace {

constexpr std::size_t kFewestPairsOfGroup = 12;
constexpr std::size_t kMostStripPairs = 12;

using Factors = std::set<FactorId>;

/// Returns the active pairs of each combination of strips, largest groups first.
std::vector<Factors> GroupByStrips(const FlightNetwork& network) {
  const std::vector<StripInterval> strips = FindStrips(network.flight());
  const auto strip_at = [&](double t_s) {
    const StripInterval* strip = StripAt(strips, t_s);
    return strip == nullptr ? static_cast<std::ptrdiff_t>(strips.size()) : strip - strips.data();
  };
  std::map<std::pair<std::ptrdiff_t, std::ptrdiff_t>, Factors> found;
  for (const PairEdge& edge : network.pairs().edges()) {
    if (!network.net().factor(edge.id).active) continue;
    found[std::minmax({strip_at(edge.pair.t_i_s), strip_at(edge.pair.t_j_s)})].insert(edge.id);
  }
  std::vector<Factors> groups;
  for (auto& [names, factors] : found) {
    if (factors.size() >= kFewestPairsOfGroup) groups.push_back(std::move(factors));
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const Factors& a, const Factors& b) { return a.size() > b.size(); });
  groups.resize(std::min(groups.size(), kMostStripPairs));
  return groups;
}

/// A boresight estimate as a linear function of all data, -G^T (residuals). Rows of data that are
/// not used are zero.
struct GroupEstimate {
  Eigen::Vector3d theta_rad = Eigen::Vector3d::Zero();
  Eigen::MatrixXd G;
};

std::optional<GroupEstimate> EstimateFromPairs(const Factors& group, const FlightNetwork& network,
                                               const LinearizedNetwork& all) {
  Network net = network.net();
  for (const PairEdge& edge : network.pairs().edges()) {
    if (group.count(edge.id) == 0) net.SetActive(edge.id, false);
  }
  const LinearizedNetwork linearized(net);
  const int first = linearized.FirstColumn(network.calibration().boresight().id);
  if (first < 0) return std::nullopt;
  Eigen::MatrixXd E = Eigen::MatrixXd::Zero(linearized.parameters(), 3);
  E.middleRows(first, 3).setIdentity();
  try {
    const Eigen::MatrixXd G = linearized.Times(Marginals(linearized).Solve(E));
    GroupEstimate estimate;
    estimate.theta_rad = -G.transpose() * linearized.residual();
    estimate.G = Eigen::MatrixXd::Zero(all.rows(), 3);
    for (const LinearizedNetwork::FactorRows& rows : linearized.factors()) {
      estimate.G.middleRows(all.FindRows(rows.factor)->first, rows.count) =
          G.middleRows(rows.first, rows.count);
    }
    return estimate;
  } catch (const RankDeficient&) {
    return std::nullopt;
  }
}

/// Returns orthonormal contrasts between n values of three components.
Eigen::MatrixXd Contrasts(Eigen::Index n) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(3 * (n - 1), 3 * n);
  for (Eigen::Index k = 1; k < n; ++k) {
    const double norm = std::sqrt(static_cast<double>(k * (k + 1)));
    for (Eigen::Index j = 0; j < k; ++j) {
      H.block<3, 3>(3 * (k - 1), 3 * j) = Eigen::Matrix3d::Identity() / norm;
    }
    H.block<3, 3>(3 * (k - 1), 3 * k) =
        -static_cast<double>(k) / norm * Eigen::Matrix3d::Identity();
  }
  return H;
}

}  // namespace

double ExcessScatter(const Eigen::VectorXd& values, const Eigen::MatrixXd& C) {
  const Eigen::MatrixXd H = Contrasts(values.size() / 3);
  const Eigen::VectorXd d = H * values;
  const Eigen::MatrixXd S = H * C * H.transpose();
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(d.size(), d.size());
  const auto too_far = [&](double tau2) {
    return d.dot((S + tau2 * I).llt().solve(d)) > static_cast<double>(d.size());
  };
  if (!too_far(0.0)) return 0.0;
  double low = 0.0, high = d.squaredNorm();
  while (too_far(high)) high *= 2.0;
  constexpr int kHalvings = 60;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (too_far(middle) ? low : high) = middle;
  }
  return std::sqrt(high);
}

std::optional<double> BoresightScatter(const FlightNetwork& network, int threads) {
  if (network.net().block(network.calibration().boresight().id).held) return std::nullopt;
  const std::vector<Factors> groups = GroupByStrips(network);
  if (groups.size() < 2) return std::nullopt;
  const LinearizedNetwork all(network.net(), threads);
  std::vector<std::optional<GroupEstimate>> estimates(groups.size());
  ParallelFor(static_cast<int>(groups.size()), threads, [&](int k) {
    const auto at = static_cast<std::size_t>(k);
    estimates[at] = EstimateFromPairs(groups[at], network, all);
  });
  std::erase_if(estimates, [](const auto& estimate) { return !estimate.has_value(); });
  const auto n = static_cast<Eigen::Index>(estimates.size());
  if (n < 2) return std::nullopt;
  Eigen::VectorXd values(3 * n);
  Eigen::MatrixXd G(all.rows(), 3 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    values.segment<3>(3 * k) = estimates[static_cast<std::size_t>(k)]->theta_rad;
    G.middleCols(3 * k, 3) = estimates[static_cast<std::size_t>(k)]->G;
  }
  return ExcessScatter(values, G.transpose() * G);
}

}  // namespace dn::diagnosis_internal
