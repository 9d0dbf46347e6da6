#include "outlier_evidence.h"

#include <dn/log_sum.h>

#include <algorithm>
#include <cmath>

namespace dn::diagnosis_internal {
namespace {

// Possible fractions of outliers, uniform in their logarithm, and the fraction of outliers that a
// threshold finds.
constexpr double kLeastShare = 1e-3, kLargestShare = 0.3, kFound = 0.7;
constexpr int kShares = 40;

/// Returns the log evidence of the number found, a Poisson variable, averaged over the fractions.
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

/// Returns the fraction of outliers above the threshold c, for lengths uniform from 0 to the
/// largest. The mean of the detected lengths is (c + largest) / 2.
double PartSeen(double largest_m, double mean_m) {
  constexpr double kLeastPart = 0.1;  // a few similar lengths say nothing about the others
  return std::clamp(2.0 * (largest_m - mean_m) / largest_m, kLeastPart, 1.0);
}

}  // namespace

HypothesisEvidence OutlierEffect(EffectId id, long found, long of_all, double usual,
                                 const std::vector<double>& lengths_m) {
  double largest_m = 0.0, sum_m = 0.0;
  for (const double length_m : lengths_m) {
    largest_m = std::max(largest_m, length_m);
    sum_m += length_m;
  }
  const auto all = static_cast<double>(of_all), n = static_cast<double>(found);
  const double part =
      largest_m > 0.0 ? PartSeen(largest_m, sum_m / static_cast<double>(lengths_m.size())) : 1.0;
  const double share = std::min(n / all / part, 1.0);
  // The number n of outliers found has a Poisson distribution, with the relative variance 1 / n.
  // The mean of n uniform lengths adds a third of that variance.
  const double sigma = std::max(share, 1.0 / all) * std::sqrt(4.0 / 3.0 / std::max(1.0, n));
  return MakeEvidence(id, Evidence(found, of_all, usual), Eigen::Vector2d(share, largest_m),
                      Eigen::Vector2d(sigma, 0.5 * largest_m));
}

double ShortOutlierVariance(double share, double size_m, double sigma_m, double norm) {
  if (!(size_m > 0.0)) return 0.0;
  const double size = size_m / sigma_m, longest = std::min(norm, size);
  return share * longest / size * longest * longest / 9.0;
}

}  // namespace dn::diagnosis_internal
