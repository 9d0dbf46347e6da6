#include "gnss_runs.h"

#include <dn/navigation/antenna_derivative.h>
#include <dn/symmetric_eigen.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kShortestRun = 8;
// Accepted positions between two parts of one run: an error passes through zero.
constexpr std::size_t kMostAcceptedWithin = 5;
// Enough positions to see the shape of a run; more cost the cube of their number.
constexpr std::size_t kMostPositions = 60;

/// GNSS positions that were left out, as indices of edges, in time.
using Run = std::vector<std::size_t>;

std::vector<Run> LeftOutRuns(const FlightNetwork& network) {
  const std::vector<GnssEdge>& edges = network.gnss().edges();
  std::vector<Run> runs;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (network.net().factor(edges[e].position).active) continue;
    if (runs.empty() || e - runs.back().back() > kMostAcceptedWithin + 1) runs.emplace_back();
    runs.back().push_back(e);
  }
  std::erase_if(runs, [](const Run& run) { return run.size() < kShortestRun; });
  return runs;
}

Run Thinned(const Run& run) {
  if (run.size() <= kMostPositions) return run;
  Run thinned;
  for (std::size_t k = 0; k < kMostPositions; ++k) {
    thinned.push_back(run[k * (run.size() - 1) / (kMostPositions - 1)]);
  }
  return thinned;
}

/// The positions of a run, predicted by all data in use.
struct PredictedRun {
  VectorXd r;                 // residuals
  MatrixXd H;                 // covariance of their prediction
  MatrixXd L;                 // derivatives by a common offset of the positions
  Marginals::Columns change;  // of the unknowns by unit residuals
};

/// Adds the derivatives of a factor, transposed, to the columns from `first` on.
void AddTransposed(const LinearizedNetwork::Factor& factor, Index first, Index columns,
                   BlockColumns* J_transposed) {
  for (const auto& [block, J] : factor.jacobian) {
    auto [at, added] = J_transposed->try_emplace(block);
    if (added) at->second = MatrixXd::Zero(J.cols(), columns);
    at->second.middleCols(first, J.rows()) = J.transpose();
  }
}

PredictedRun Predict(const FlightNetwork& network, const Marginals& marginals, const Run& run) {
  const LinearizedNetwork& linearized = marginals.linearized();
  const auto n = 3 * static_cast<Index>(run.size());
  VectorXd r(n);
  MatrixXd L(n, 3);
  BlockColumns J_transposed;
  for (std::size_t k = 0; k < run.size(); ++k) {
    const GnssEdge& edge = network.gnss().edges()[run[k]];
    LinearizedNetwork::Factor factor = linearized.EvaluateFactorAt(edge.position);
    std::erase_if(factor.jacobian,
                  [&](const auto& of_block) { return linearized.FirstColumn(of_block.first) < 0; });
    const auto first = 3 * static_cast<Index>(k);
    r.segment<3>(first) = factor.residual;
    L.middleRows<3>(first) = AntennaDerivative(network, edge, factor);
    AddTransposed(factor, first, n, &J_transposed);
  }
  Marginals::Columns change = marginals.Solve(J_transposed);
  MatrixXd H = MatrixXd::Zero(n, n);
  for (const auto& [block, J] : J_transposed) H += J.transpose() * change.Rows(block);
  return {std::move(r), 0.5 * (H + H.transpose()), std::move(L), std::move(change)};
}

/// Log likelihood of r ~ N(0, diag(variance)), up to a constant.
double LogNormal(const VectorXd& r, const VectorXd& variance) {
  return -0.5 * (variance.array().log() + r.array().square() / variance.array()).sum();
}

/// Returns the largest value over sizes from 2^-10 to 2^20, on a grid of quarters of an octave.
double LargestOverSizes(const std::function<double(double)>& log_likelihood) {
  double largest = -std::numeric_limits<double>::infinity();
  for (double octave = -10.0; octave <= 20.0; octave += 0.25) {
    largest = std::max(largest, log_likelihood(std::exp2(octave)));
  }
  return largest;
}

GnssRunCheck CheckRun(const FlightNetwork& network, const Marginals& marginals, const Run& run,
                      const std::vector<BlockId>& watched, const TestFamily& family) {
  const PredictedRun predicted = Predict(network, marginals, Thinned(run));
  const auto t_s = [&](std::size_t edge) {
    return network.flight().gnss->epochs[network.gnss().edges()[edge].epoch].t_s;
  };
  GnssRunCheck check;
  check.t0_s = t_s(run.front());
  check.t1_s = t_s(run.back());
  check.positions = static_cast<long>(run.size());
  check.log_gnss_over_inertial = LogGnssOverInertial(predicted.r, predicted.H, predicted.L);
  const Index n = predicted.r.size();
  const VectorXd weighted = (predicted.H + MatrixXd::Identity(n, n)).llt().solve(predicted.r);
  VectorXd shift(family.watched_sigma.size());
  for (std::size_t k = 0; k < watched.size(); ++k) {
    shift.segment<3>(3 * static_cast<Index>(k)) = -predicted.change.Rows(watched[k]) * weighted;
  }
  check.boresight_rad = family.BoresightShift(shift);
  check.max_shift_sigmas = family.InSigmas(shift);
  return check;
}

}  // namespace

double LogGnssOverInertial(const VectorXd& r, const MatrixXd& H, const MatrixXd& L) {
  const SymmetricEigen eigen(H);
  const VectorXd variance = eigen.values.cwiseMax(0.0);
  const VectorXd u = eigen.vectors.transpose() * r;
  const MatrixXd V = eigen.vectors.transpose() * L;
  const double inertial = LargestOverSizes(
      [&](double k) { return LogNormal(u, ((k * k * variance).array() + 1.0).matrix()); });
  const double gnss = LargestOverSizes([&](double s) {
    const VectorXd total = (variance.array() + 1.0 + s * s).matrix();
    const MatrixXd weighted = total.cwiseInverse().asDiagonal() * V;
    const VectorXd offset = (V.transpose() * weighted).ldlt().solve(weighted.transpose() * u);
    return LogNormal(u - V * offset, total);
  });
  return gnss - inertial - 1.5 * std::log(static_cast<double>(r.size()));
}

std::vector<GnssRunCheck> CheckGnssRuns(const FlightNetwork& network, const Marginals& marginals,
                                        const std::vector<BlockId>& watched,
                                        const TestFamily& family) {
  std::vector<GnssRunCheck> checks;
  for (const Run& run : LeftOutRuns(network)) {
    checks.push_back(CheckRun(network, marginals, run, watched, family));
  }
  return checks;
}

}  // namespace dn::diagnosis_internal
