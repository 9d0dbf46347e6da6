#include <dn/median.h>
#include <dn/navigation/slow_gnss_errors.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "positions_in_use.h"

namespace dn {
namespace {

using Eigen::Matrix3Xd;
using navigation_internal::PositionInUse;

constexpr std::size_t kFewestForIntervals = 50;
// Positions whose white part exceeds this share of the stated variance are taken as stated.
constexpr double kMostWhiteVariance = 0.25;
// Receivers filter their positions: errors closer together than this are alike even if most of them
// is white.
constexpr double kShortestInterval_s = 1.0;
// Small inertial units keep the trajectory smooth over this time.
constexpr double kLongestInterval_s = 8.0;
// Intervals differ from their nominal length by at most this share of the median interval.
constexpr double kIntervalTolerance = 0.25;
// Errors that no longer correlate after an interval give a time constant of a third of it.
constexpr double kMostGrowth = 0.95;
constexpr double kLongestTau_s = 3600.0;

/// The errors of all positions, east, north, up.
struct PositionErrors {
  std::vector<double> t_s;
  Matrix3Xd in_sigmas;  // residuals, divided by the stated sigmas
  Eigen::Vector3d sigma_enu_m;
};

PositionErrors FindErrors(const std::vector<PositionInUse>& positions,
                          const Eigen::VectorXd& residual) {
  PositionErrors errors;
  errors.in_sigmas.resize(3, static_cast<Eigen::Index>(positions.size()));
  std::vector<double> sigmas_m[3];
  for (const PositionInUse& position : positions) {
    const Eigen::Matrix3d m_from_residual = position.L.inverse();
    const Eigen::Vector3d sigma_m = m_from_residual.rowwise().norm();
    const auto k = static_cast<Eigen::Index>(errors.t_s.size());
    errors.in_sigmas.col(k) =
        (m_from_residual * residual.segment<3>(position.first_row)).cwiseQuotient(sigma_m);
    errors.t_s.push_back(position.t_s);
    for (int axis = 0; axis < 3; ++axis) sigmas_m[axis].push_back(sigma_m[axis]);
  }
  for (int axis = 0; axis < 3; ++axis) errors.sigma_enu_m[axis] = Median(sigmas_m[axis]);
  return errors;
}

/// Returns half the mean square of the differences of errors `step` positions apart, on the axis
/// where it is largest, or 0 if there are few of them.
double HalfSquare(const PositionErrors& errors, std::size_t step, double interval_s) {
  const double nominal_s = static_cast<double>(step) * interval_s;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (std::size_t k = step; k < errors.t_s.size(); ++k) {
    const double apart_s = errors.t_s[k] - errors.t_s[k - step];
    if (std::abs(apart_s - nominal_s) > kIntervalTolerance * interval_s) continue;
    const auto at = static_cast<Eigen::Index>(k);
    sum += (errors.in_sigmas.col(at) - errors.in_sigmas.col(at - static_cast<Eigen::Index>(step)))
               .cwiseAbs2();
    ++count;
  }
  return count < kFewestForIntervals / 2 ? 0.0
                                         : sum.maxCoeff() / (2.0 * static_cast<double>(count));
}

/// Returns the shortest time constant that the growth of the differences demands.
double ShortestTau(const PositionErrors& errors, std::size_t shortest, double interval_s,
                   double white_variance) {
  double tau_s = kLongestTau_s;
  for (std::size_t step = 2 * shortest;
       static_cast<double>(step) * interval_s <= kLongestInterval_s; step *= 2) {
    const double growth =
        (HalfSquare(errors, step, interval_s) - white_variance) / (1.0 - white_variance);
    if (growth <= 0.0) continue;
    tau_s = std::min(tau_s, -static_cast<double>(step) * interval_s /
                                std::log(1.0 - std::min(growth, kMostGrowth)));
  }
  return tau_s;
}

}  // namespace

std::optional<SlowGnssErrors> FindSlowGnssErrors(const FlightNetwork& network,
                                                 const LinearizedNetwork& linearized) {
  const std::vector<PositionInUse> positions =
      navigation_internal::PositionsInUse(network, linearized);
  if (positions.size() < kFewestForIntervals) return std::nullopt;
  const PositionErrors errors = FindErrors(positions, linearized.residual());
  const double interval_s = navigation_internal::MedianInterval(positions);
  const auto shortest =
      static_cast<std::size_t>(std::max(1.0, std::round(kShortestInterval_s / interval_s)));
  const double white_variance = HalfSquare(errors, shortest, interval_s);
  if (white_variance <= 0.0 || white_variance > kMostWhiteVariance) return std::nullopt;
  SlowGnssErrors slow;
  slow.white_share = std::sqrt(white_variance);
  slow.process.sigma_enu_m = std::sqrt(1.0 - white_variance) * errors.sigma_enu_m;
  slow.process.tau_s = ShortestTau(errors, shortest, interval_s, white_variance);
  return slow;
}

}  // namespace dn
