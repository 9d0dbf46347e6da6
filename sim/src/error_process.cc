#include <dn/error.h>
#include <dn/sim/error_process.h>
#include <dn/sim/random.h>

#include <cmath>

namespace dn {
namespace {

/// Returns 2a - 3 + 4 exp(-a) - exp(-2a) without cancellation, as sum_{n>=3} (-a)^n (4 - 2^n) / n!.
double IntegralVarianceFactor(double a) {
  if (a > 1.0) return 2.0 * a - 3.0 + 4.0 * std::exp(-a) - std::exp(-2.0 * a);
  double sum = 0.0;
  double term = 0.5 * a * a;  // (-a)^n / n!, starting at n = 2
  double power = 4.0;         // 2^n
  for (int n = 3; n <= 30; ++n) {
    term *= -a / n;
    power *= 2.0;
    sum += term * (4.0 - power);
  }
  return sum;
}

Eigen::Matrix2d GaussMarkovCovariance(double sigma, double tau_s, double dt_s) {
  const double a = dt_s / tau_s;
  const double loss = -std::expm1(-a);  // 1 - exp(-a)
  const double end = -std::expm1(-2.0 * a);
  const double cross = loss * loss / a;
  const double mean = IntegralVarianceFactor(a) / (a * a);
  Eigen::Matrix2d C;
  C << end, cross, cross, mean;
  return sigma * sigma * C;
}

Eigen::Matrix2d RandomWalkCovariance(double sigma, double dt_s) {
  Eigen::Matrix2d C;
  C << 1.0, 0.5, 0.5, 1.0 / 3.0;
  return sigma * sigma * dt_s * C;
}

}  // namespace

Eigen::Matrix2d IntervalCovariance(const BiasProcess& model, double dt_s) {
  if (!(dt_s > 0.0)) throw InvalidInput("a sample interval must be positive");
  switch (model.type) {
    case BiasProcess::Type::kGaussMarkov:
      return GaussMarkovCovariance(model.sigma, model.tau_s, dt_s);
    case BiasProcess::Type::kRandomWalk:
      return RandomWalkCovariance(model.sigma, dt_s);
    case BiasProcess::Type::kRandomConstant:
      break;
  }
  return Eigen::Matrix2d::Zero();
}

ErrorProcess::ErrorProcess(const BiasProcess& model, double dt_s, Random& random) {
  const Eigen::Matrix2d C = IntervalCovariance(model, dt_s);
  if (model.type == BiasProcess::Type::kGaussMarkov) {
    const double a = dt_s / model.tau_s;
    decay_ = std::exp(-a);
    mean_gain_ = -std::expm1(-a) / a;
  }
  if (model.type != BiasProcess::Type::kRandomWalk) value_ = model.sigma * random.Normal();
  if (C(0, 0) > 0.0) {
    L_(0, 0) = std::sqrt(C(0, 0));
    L_(1, 0) = C(1, 0) / L_(0, 0);
    L_(1, 1) = std::sqrt(C(1, 1) - L_(1, 0) * L_(1, 0));
  }
}

double ErrorProcess::NextMean(Random& random) {
  const double start = value_;
  if (L_(0, 0) == 0.0) return start;
  const double n0 = random.Normal(), n1 = random.Normal();
  value_ = decay_ * start + L_(0, 0) * n0;
  return mean_gain_ * start + L_(1, 0) * n0 + L_(1, 1) * n1;
}

}  // namespace dn
