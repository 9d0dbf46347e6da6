#include "outlier_evidence.h"

#include <dn/log_sum.h>

#include <algorithm>
#include <cmath>

namespace dn::internal {
namespace {

// Shares of gross errors that may be there, alike in their logarithm, and how many of them a
// threshold finds.
constexpr double kLeastShare = 1e-3, kLargestShare = 0.3, kFound = 0.7;
constexpr int kShares = 40;

/// Of the number found, a Poisson variable, averaged over the shares.
double Evidence(long found, long of_all, double usual) {
  const auto all = static_cast<double>(of_all), n = static_cast<double>(found);
  const double expected = std::max(usual * all, 1e-3);
  LogSum sum;
  for (int k = 0; k < kShares; ++k) {
    const double share = kLeastShare * std::pow(kLargestShare / kLeastShare, (k + 0.5) / kShares);
    const double with = expected + kFound * share * all;
    sum.Add(n * std::log(with / expected) - (with - expected));
  }
  return sum.Value() - std::log(kShares);
}

}  // namespace

ScreenedEffect OutlierEffect(const std::string& name, long found, long of_all, double usual,
                             double size_m) {
  ScreenedEffect effect;
  effect.name = name;
  effect.log_evidence = Evidence(found, of_all, usual);
  effect.p_value = std::min(1.0, std::exp(-effect.log_evidence));
  const double all = static_cast<double>(of_all);
  effect.estimate = Eigen::Vector2d(static_cast<double>(found) / all, size_m);
  const double sigma = std::sqrt(std::max(1.0, static_cast<double>(found))) / all;
  effect.sigma = Eigen::Vector2d(sigma, 0.5 * size_m);
  return effect;
}

}  // namespace dn::internal
