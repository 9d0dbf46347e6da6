#include <dn/error.h>
#include <dn/imu/allan.h>

#include <cmath>
#include <cstddef>
#include <string>

namespace dn {
namespace {

constexpr std::size_t kFewestValues = 100;
constexpr std::size_t kClustersAtLeast = 5;

// Returns the running sum times dt. The mean is subtracted first so that no digits are lost.
std::vector<double> Angles(const std::vector<double>& rates, double dt_s) {
  double mean = 0.0;
  for (const double rate : rates) mean += rate / static_cast<double>(rates.size());
  std::vector<double> theta(rates.size() + 1, 0.0);
  for (std::size_t k = 0; k < rates.size(); ++k) theta[k + 1] = theta[k] + (rates[k] - mean) * dt_s;
  return theta;
}

// Returns the equivalent degrees of freedom of overlapping estimates for white rate noise, from n
// angles.
double EquivalentDof(std::size_t angles, std::size_t m) {
  const auto n = static_cast<double>(angles), M = static_cast<double>(m);
  return (1.5 * (n - 1.0) / M - 2.0 * (n - 2.0) / n) * 4.0 * M * M / (4.0 * M * M + 5.0);
}

}  // namespace

double AllanPoint::deviation() const { return std::sqrt(variance); }
double AllanPoint::sigma_of_deviation() const { return deviation() / std::sqrt(2.0 * dof); }

std::vector<AllanPoint> AllanVariance(const std::vector<double>& rates, double dt_s) {
  if (rates.size() < kFewestValues) {
    throw InvalidInput("Allan variance: " + std::to_string(rates.size()) +
                       " values are too few, at least " + std::to_string(kFewestValues) +
                       " are needed");
  }
  if (!(dt_s > 0.0)) throw InvalidInput("Allan variance: the interval must be positive");
  for (const double rate : rates) {
    if (!std::isfinite(rate)) throw InvalidInput("Allan variance: a value is not finite");
  }
  const std::vector<double> theta = Angles(rates, dt_s);
  std::vector<AllanPoint> curve;
  for (std::size_t m = 1; m * kClustersAtLeast <= rates.size(); m *= 2) {
    const double tau_s = static_cast<double>(m) * dt_s;
    double sum = 0.0;
    const std::size_t count = theta.size() - 2 * m;
    for (std::size_t k = 0; k < count; ++k) {
      const double d = theta[k + 2 * m] - 2.0 * theta[k + m] + theta[k];
      sum += d * d;
    }
    curve.push_back({tau_s, sum / (2.0 * tau_s * tau_s * static_cast<double>(count)),
                     EquivalentDof(theta.size(), m)});
  }
  return curve;
}

std::vector<AllanPoint> MeanCurve(const std::vector<std::vector<AllanPoint>>& curves) {
  std::vector<AllanPoint> mean = curves.front();
  for (std::size_t p = 0; p < mean.size(); ++p) {
    double sum = 0.0, sum2 = 0.0;
    for (const auto& curve : curves) {
      sum += curve[p].variance;
      sum2 += curve[p].variance * curve[p].variance / curve[p].dof;
    }
    mean[p].variance = sum / static_cast<double>(curves.size());
    // Degrees of freedom of a sum of independent estimates of different size.
    mean[p].dof = sum * sum / sum2;
  }
  return mean;
}

double GaussMarkovAllanVariance(double tau_s, double correlation_s) {
  const double a = tau_s / correlation_s;
  if (a < 1e-3) return 2.0 / 3.0 * a * (1.0 - 0.75 * a);  // series of the expression below
  return 2.0 / a * (1.0 - (3.0 - 4.0 * std::exp(-a) + std::exp(-2.0 * a)) / (2.0 * a));
}

}  // namespace dn
