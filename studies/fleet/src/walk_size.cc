#include "walk_size.h"

#include <cmath>
#include <limits>
#include <utility>

namespace dn::fleet_internal {
namespace {

// Sizes relative to the sigma of a flight's boresight: from far below it to far above it.
constexpr double kSmallest = 1e-2, kLargest = 1e4, kStep = 1.25;
constexpr int kBisections = 30;
// Half the 0.9 quantile of chi-square with one degree of freedom.
constexpr double kUpperLimitNats = 1.3528;

/// Returns the sigma that the boresight of a flight typically has if all effects are known.
double TypicalSigma(const FleetLikelihood& likelihood) {
  double trace = 0.0;
  for (Eigen::Index k = 0; k < 3 * likelihood.flights; ++k) {
    trace += likelihood.information(k, k);
  }
  return std::sqrt(3.0 * static_cast<double>(likelihood.flights) / trace);
}

class Climb {
 public:
  explicit Climb(const FleetLikelihood& likelihood) : likelihood_(likelihood) {}

  double At(double walk_rad) const { return FleetEstimate(likelihood_, walk_rad).LogLikelihood(); }

  /// Returns the size of the largest likelihood within a bracket, by golden section.
  double Refine(double low, double high) const {
    constexpr double kGolden = 0.6180339887498949;
    for (int k = 0; k < kBisections; ++k) {
      const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
      if (At(a) < At(b)) {
        low = a;
      } else {
        high = b;
      }
    }
    return 0.5 * (low + high);
  }

  /// Returns the size above `low` at which the log likelihood falls to `level`.
  double Fall(double low, double high, double level) const {
    for (int k = 0; k < kBisections; ++k) {
      const double middle = 0.5 * (low + high);
      (At(middle) > level ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

 private:
  const FleetLikelihood& likelihood_;
};

}  // namespace

BoresightWalk EstimateWalk(const FleetLikelihood& likelihood) {
  const Climb climb(likelihood);
  const double typical = TypicalSigma(likelihood), constant = climb.At(0.0);
  std::vector<std::pair<double, double>> grid{{0.0, constant}};
  std::size_t best = 0;
  for (double size = kSmallest * typical; size < kLargest * typical; size *= kStep) {
    grid.emplace_back(size, climb.At(size));
    if (grid.back().second > grid[best].second) best = grid.size() - 1;
    if (grid.back().second < grid[best].second - 2.0 * kUpperLimitNats) break;
  }
  BoresightWalk walk;
  if (best > 0 && best + 1 < grid.size()) {
    walk.sigma_rad = climb.Refine(grid[best - 1].first, grid[best + 1].first);
    walk.log_ratio = std::max(0.0, climb.At(walk.sigma_rad) - constant);
    if (walk.log_ratio == 0.0) walk.sigma_rad = 0.0;
  }
  const double level = constant + walk.log_ratio - kUpperLimitNats;
  walk.upper_rad = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < grid.size(); ++k) {
    if (grid[k].first < walk.sigma_rad || grid[k].second > level) continue;
    walk.upper_rad = climb.Fall(std::max(walk.sigma_rad, grid[k - 1].first), grid[k].first, level);
    break;
  }
  return walk;
}

}  // namespace dn::fleet_internal
