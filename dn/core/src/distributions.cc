#include <dn/distributions.h>

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/SpecialFunctions>
#include <vector>

namespace dn {
namespace {

// The incomplete gamma function loses digits for large arguments. For this many degrees of freedom,
// the cube root of a chi-square variable (Wilson and Hilferty 1931) is normal to better than 1e-6.
constexpr double kLargeDof = 1e5;

// Finds the root of an increasing function by bisection, which always converges to the last digits.
template <class Function>
double Root(const Function& rising, double low, double high) {
  for (int i = 0; i < 200 && low < high; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    (rising(middle) < 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double LogBinomial(long n, long k, double p) {
  const auto N = static_cast<double>(n);
  const auto K = static_cast<double>(k);
  return std::lgamma(N + 1.0) - std::lgamma(K + 1.0) - std::lgamma(N - K + 1.0) + K * std::log(p) +
         (N - K) * std::log1p(-p);
}

}  // namespace

double ChiSquareCdf(double x, double dof) {
  if (x <= 0.0) return 0.0;
  if (dof < kLargeDof) return Eigen::numext::igamma(0.5 * dof, 0.5 * x);
  const double variance = 2.0 / (9.0 * dof);
  return 0.5 * std::erfc(-(std::cbrt(x / dof) - 1.0 + variance) / std::sqrt(2.0 * variance));
}

double ChiSquareTail(double x, double dof) {
  if (x <= 0.0) return 1.0;
  if (dof < kLargeDof) return Eigen::numext::igammac(0.5 * dof, 0.5 * x);
  const double variance = 2.0 / (9.0 * dof);
  return 0.5 * std::erfc((std::cbrt(x / dof) - 1.0 + variance) / std::sqrt(2.0 * variance));
}

double ChiSquareQuantile(double p, double dof) {
  double high = dof + 10.0;
  while (ChiSquareCdf(high, dof) < p) high *= 2.0;
  return Root([&](double x) { return ChiSquareCdf(x, dof) - p; }, 0.0, high);
}

Interval ChiSquareInterval(double probability, double dof) {
  const double tail = 0.5 * (1.0 - probability);
  return {ChiSquareQuantile(tail, dof) / dof, ChiSquareQuantile(1.0 - tail, dof) / dof};
}

double NormalQuantile(double p) { return Eigen::numext::ndtri(p); }

Interval BinomialInterval(double probability, long n, double p) {
  const double tail = 0.5 * (1.0 - probability);
  const auto N = static_cast<double>(n);
  Interval interval{0.0, 1.0};
  double below = 0.0;
  bool low_found = false;
  for (long k = 0; k <= n; ++k) {
    const double up_to = below + std::exp(LogBinomial(n, k, p));
    if (!low_found && up_to > tail) {
      interval.low = static_cast<double>(k) / N;
      low_found = true;
    }
    if (up_to >= 1.0 - tail) {
      interval.high = static_cast<double>(k) / N;
      break;
    }
    below = up_to;
  }
  return interval;
}

double UniformityPValue(std::vector<double> values, double reference_size) {
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  double largest = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto below = static_cast<double>(k) / n, up_to = static_cast<double>(k + 1) / n;
    // A rank is only known to one step of the reference.
    largest = std::max({largest, up_to - values[k], values[k] - 1.0 / reference_size - below});
  }
  const double root = std::sqrt(n * reference_size / (n + reference_size));
  const double x = largest * (root + 0.12 + 0.11 / root);
  if (x < 0.3) return 1.0;  // the series converges slowly there, but the tail is 1 within 1e-5
  double tail = 0.0;
  constexpr int kTerms = 100;
  for (int k = 1; k <= kTerms; ++k) {
    tail += (k % 2 == 1 ? 2.0 : -2.0) * std::exp(-2.0 * k * k * x * x);
  }
  return std::clamp(tail, 0.0, 1.0);
}

}  // namespace dn
