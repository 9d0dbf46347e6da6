#include "noise_evidence.h"

#include <dn/size_prior.h>

#include <algorithm>
#include <array>
#include <numbers>

namespace dn {
namespace {

/// Standard deviations of the logarithm of sigma between levels.
constexpr std::array<double, 6> kSpreads{0.003, 0.01, 0.03, 0.1, 0.3, 1.0};

double LogNormal(double x, double variance) {
  return -0.5 * (x * x / variance + std::log(2.0 * std::numbers::pi * variance));
}

/// Returns the evidence of levels that scatter about a common level with a known spread.
double SpreadEvidence(const std::vector<LogLevel>& levels, double spread, const RatioPrior& prior) {
  double weight = 0.0, mean = 0.0;
  for (const LogLevel& level : levels) {
    const double w = 1.0 / (level.variance + spread * spread);
    weight += w;
    mean += w * level.u;
  }
  mean /= weight;
  double evidence = prior.Log(mean, 1.0 / weight) + 0.5 * std::log(2.0 * std::numbers::pi / weight);
  for (const LogLevel& level : levels) {
    evidence += level.log_likelihood + 0.5 * std::log(2.0 * std::numbers::pi * level.variance) +
                LogNormal(level.u - mean, level.variance + spread * spread);
  }
  return evidence;
}

}  // namespace

double LogLikelihood(const BandEnergy& energy, double v) {
  return -0.5 * (energy.dof * std::log(v) + energy.sum * (1.0 / v - 1.0));
}

double NoiseLevels::Ratio(const BandEnergy& energy) const {
  constexpr double kLeast2 = 1e-6;
  return std::sqrt(std::max(kLeast2, energy.Variance() * (1.0 + rounding_) - rounding_));
}

double NoiseLevels::Sigma(const BandEnergy& energy) const {
  return energy.Variance() * (1.0 + rounding_) / (Ratio(energy) * std::sqrt(2.0 * energy.dof));
}

LogLevel NoiseLevels::Level(const BandEnergy& energy) const {
  const double ratio = Ratio(energy);
  const double v = (ratio * ratio + rounding_) / (1.0 + rounding_);
  return {std::log(ratio), std::pow(Sigma(energy) / ratio, 2), LogLikelihood(energy, v)};
}

double RatioPrior::Log(double u, double variance) const {
  LogSum sum;
  for (std::size_t g = 0; g < SizePrior::kSizes; ++g) {
    sum.Add(std::log(SizePrior::kProbability[g]) +
            LogNormal(u, std::pow(sigma_ * SizePrior::kTimesTypical[g], 2) + variance));
  }
  return sum.Value();
}

double LevelEvidence(const LogLevel& level, const RatioPrior& prior) {
  return level.log_likelihood + prior.Log(level.u, level.variance) +
         0.5 * std::log(2.0 * std::numbers::pi * level.variance);
}

double DifferentLevelsEvidence(const std::vector<LogLevel>& levels, const RatioPrior& prior) {
  if (levels.empty()) return 0.0;
  LogSum sum;
  for (const double spread : kSpreads) {
    sum.Add(SpreadEvidence(levels, spread, prior) - std::log(kSpreads.size()));
  }
  return sum.Value();
}

Addition::Addition(double typical_sigma, double assumed_sigma, double spread_decades)
    : typical_log_(2.0 * std::log(typical_sigma / assumed_sigma)),
      spread2_(std::pow(2.0 * std::numbers::ln10 * spread_decades, 2)),
      log_norm_(0.5 * std::log(2.0 * std::numbers::pi * spread2_)) {}

double Addition::Evidence(const BandEnergy& energy, double base) const {
  if (!(energy.dof > 0.0)) return 0.0;
  constexpr int kSteps = 16;
  constexpr double kFrom = 0.1, kTo = 8.0, kClear = 4.0;
  const double shift = typical_log_ - std::log(base);
  const double excess = energy.Variance() - 1.0;
  const double sigma = std::sqrt(2.0 / energy.dof) * (1.0 + std::max(0.0, excess));
  if (excess > kClear * sigma) {  // Laplace approximation in log(theta)
    return LogLikelihood(energy, 1.0 + excess) + LogPrior(std::log(excess) - shift) +
           std::log(sigma / excess * std::sqrt(2.0 * std::numbers::pi));
  }
  const double from = std::log(kFrom * sigma);
  const double to = std::log(std::max(0.0, excess) + kTo * sigma);
  const double step = (to - from) / kSteps;
  const double peak = LogLikelihood(energy, std::max(1.0, energy.Variance()));
  double sum = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    const double x = from + (k + 0.5) * step;
    sum += std::exp(LogPrior(x - shift) + LogLikelihood(energy, 1.0 + std::exp(x)) - peak);
  }
  const double does_not_show =
      0.5 * std::erfc((shift - from) / (std::sqrt(spread2_) * std::numbers::sqrt2));
  return peak + std::log(step * sum + does_not_show * std::exp(-peak));
}

double Addition::LogPrior(double distance) const {
  return -0.5 * distance * distance / spread2_ - log_norm_;
}

double BestAddition(const BandEnergy& energy) {
  return energy.dof > 0.0 ? LogLikelihood(energy, std::max(1.0, energy.Variance())) : 0.0;
}

}  // namespace dn
