#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace dn::matching_internal {

/// Standard deviation of the differences that agree within a tolerance, as a share of it.
inline constexpr double kSigmaPerTolerance = 0.3;

/// Fewest pairs that align a boresight.
inline constexpr std::size_t kFewestToAlign = 3;

/// The difference of two points that should coincide, linearised in a change d of boresights:
/// w + A d, m. There are three columns per boresight.
template <int Columns>
struct DifferenceLine {
  Eigen::Vector3d w;
  Eigen::Matrix<double, 3, Columns> A;
};

/// Returns the change d from some of the lines, rad, with a prior at zero of the standard deviation
/// prior_rad. sigma_m: that of each coordinate. `lines` must not be empty.
template <int Columns>
Eigen::Matrix<double, Columns, 1> SolveLines(const std::vector<DifferenceLine<Columns>>& lines,
                                             const std::vector<std::size_t>& which, double sigma_m,
                                             double prior_rad) {
  const Eigen::Index n = lines.front().A.cols();
  Eigen::Matrix<double, Columns, Columns> N =
      Eigen::Matrix<double, Columns, Columns>::Identity(n, n) / (prior_rad * prior_rad);
  Eigen::Matrix<double, Columns, 1> h = Eigen::Matrix<double, Columns, 1>::Zero(n);
  for (const std::size_t k : which) {
    N += lines[k].A.transpose() * lines[k].A / (sigma_m * sigma_m);
    h += lines[k].A.transpose() * lines[k].w / (sigma_m * sigma_m);
  }
  return -N.ldlt().solve(h);
}

/// Returns the lines that agree to tolerance_m with the best of many changes. Each change is that
/// of two random lines, or of one more for each further boresight.
template <int Columns>
std::vector<std::size_t> LargestConsensus(const std::vector<DifferenceLine<Columns>>& lines,
                                          double tolerance_m, double prior_rad,
                                          std::uint64_t seed) {
  constexpr int kTrials = 2000;
  std::mt19937_64 engine(seed);
  std::vector<std::size_t> best, drawn(static_cast<std::size_t>(1 + lines.front().A.cols() / 3));
  for (int trial = 0; trial < kTrials; ++trial) {
    for (std::size_t& each : drawn) each = engine() % lines.size();
    if (drawn[0] == drawn[1]) continue;
    const auto d = SolveLines(lines, drawn, kSigmaPerTolerance * tolerance_m, prior_rad);
    std::vector<std::size_t> agreeing;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      if ((lines[k].w + lines[k].A * d).norm() < tolerance_m) agreeing.push_back(k);
    }
    if (agreeing.size() > best.size()) best = std::move(agreeing);
  }
  return best;
}

}  // namespace dn::matching_internal
