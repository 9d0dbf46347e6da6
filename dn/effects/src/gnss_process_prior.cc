#include <dn/effects/gnss_process_prior.h>
#include <dn/log_sum.h>

#include <cmath>

namespace dn {
namespace {

constexpr int kHalfOctaves = 10;  // sizes on each side of the median
constexpr double kTauStep = 2.34;

}  // namespace

std::vector<GnssProcessPrior::Size> GnssProcessPrior::Sizes() {
  std::vector<Size> sizes;
  LogSum sum;
  for (int k = -kHalfOctaves; k <= kHalfOctaves; ++k) {
    const double log_ratio = 0.5 * k * std::log(2.0);
    const double in_sigmas = log_ratio / kLogSizeSigma;
    sizes.push_back({kMedianSize * std::exp(log_ratio), -0.5 * in_sigmas * in_sigmas});
    sum.Add(sizes.back().log_probability);
  }
  for (Size& size : sizes) size.log_probability -= sum.Value();
  return sizes;
}

std::vector<double> GnssProcessPrior::TausS(double length_s) {
  std::vector<double> taus_s{kShortestTauS};
  while (taus_s.back() * kTauStep <= std::min(kLongestTauS, 0.5 * length_s)) {
    taus_s.push_back(taus_s.back() * kTauStep);
  }
  return taus_s;
}

}  // namespace dn
