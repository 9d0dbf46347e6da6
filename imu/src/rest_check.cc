#include <dn/imu/rest_check.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dn {
namespace {

double Mean(const std::vector<double>& values, std::size_t first, std::size_t past) {
  const auto begin = values.begin();
  return std::accumulate(begin + static_cast<std::ptrdiff_t>(first),
                         begin + static_cast<std::ptrdiff_t>(past), 0.0) /
         static_cast<double>(past - first);
}

}  // namespace

double MeanRate(const std::vector<double>& rates) { return Mean(rates, 0, rates.size()); }

bool AtRest(const std::vector<double>& rates, double dt_s, double limit) {
  const auto second = static_cast<std::size_t>(std::max(1.0, std::round(1.0 / dt_s)));
  const double mean = MeanRate(rates);
  for (std::size_t k = 0; k + second <= rates.size(); k += second) {
    if (std::abs(Mean(rates, k, k + second) - mean) > limit) return false;
  }
  return true;
}

double DriftInSigmas(const std::vector<double>& rates, double dt_s, const NoiseFit& fit) {
  const std::size_t third = rates.size() / 3;
  const double drift = Mean(rates, rates.size() - third, rates.size()) - Mean(rates, 0, third);
  NoiseFit stationary = fit;
  stationary.random_walk.reset();
  const double tau_s = static_cast<double>(third) * dt_s;
  return drift / std::sqrt(2.0 * std::max(stationary.Variance(tau_s), 1e-300));
}

}  // namespace dn
