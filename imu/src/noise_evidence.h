#pragma once

#include <dn/imu/high_band.h>
#include <dn/log_sum.h>

#include <cmath>
#include <limits>
#include <vector>

namespace dn {

/// Returns log(L(v) / L(1)); see CheckNoise.
double LogLikelihood(const BandEnergy& energy, double v);

/// Noise level in logarithmic form: u = log(ratio), normal about the estimate.
struct LogLevel {
  double u = 0.0;
  double variance = 0.0;
  double log_likelihood = 0.0;  ///< at the estimate, relative to u = 0
};

/// Noise levels of one triad. Energies refer to the assumed noise plus the rounding of the data; a
/// ratio refers to the noise alone.
class NoiseLevels {
 public:
  explicit NoiseLevels(double rounding) : rounding_(rounding) {}

  /// Returns the ratio of the actual to the assumed sigma.
  double Ratio(const BandEnergy& energy) const;
  double Sigma(const BandEnergy& energy) const;  ///< standard deviation of the ratio
  /// Returns the level with its uncertainty and likelihood.
  LogLevel Level(const BandEnergy& energy) const;

 private:
  double rounding_;
};

/// Prior of log(ratio); see NoiseCheckOptions.
class RatioPrior {
 public:
  explicit RatioPrior(double typical_ratio) : sigma_(std::log(typical_ratio)) {}

  /// Returns the logarithm of the integral of the prior times a normal density about u.
  double Log(double u, double variance) const;

 private:
  double sigma_;
};

/// Returns the evidence of one common level, relative to the assumed level.
double LevelEvidence(const LogLevel& level, const RatioPrior& prior);

/// Returns the evidence of levels that scatter about a common level with an unknown spread.
double DifferentLevelsEvidence(const std::vector<LogLevel>& levels, const RatioPrior& prior);

/// White noise in addition to that of one triad. Its variance theta is in units of the assumed one.
class Addition {
 public:
  Addition(double typical_sigma, double assumed_sigma, double spread_decades);

  /// Returns the logarithm of the integral of L(base (1 + theta)) / L(base) over the prior. The
  /// energy is in units of base.
  double Evidence(const BandEnergy& energy, double base) const;

 private:
  /// Log prior density; `distance` is that of log(theta) from the centre of the prior.
  double LogPrior(double distance) const;

  double typical_log_;
  double spread2_;
  double log_norm_;
};

/// Returns the log-likelihood of the most likely additional noise.
double BestAddition(const BandEnergy& energy);

}  // namespace dn
