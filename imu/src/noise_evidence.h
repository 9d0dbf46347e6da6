#pragma once

#include <dn/imu/high_band.h>
#include <dn/log_sum.h>

#include <cmath>
#include <limits>
#include <vector>

namespace dn {

/// log(L(v) / L(1)), see CheckNoise.
double LogLikelihood(const BandEnergy& energy, double v);

/// A level by its logarithm: u = log(ratio), normal about the estimate.
struct LogLevel {
  double u = 0.0;
  double variance = 0.0;
  double log_likelihood = 0.0;  ///< at the estimate, against u = 0
};

/// Levels of one triad. Energies are of the assumed noise with the rounding of the data; a ratio is
/// of the noise alone.
class NoiseLevels {
 public:
  explicit NoiseLevels(double rounding) : rounding_(rounding) {}

  double Ratio(const BandEnergy& energy) const;
  double Sigma(const BandEnergy& energy) const;  ///< of the ratio
  LogLevel Of(const BandEnergy& energy) const;

 private:
  double rounding_;
};

/// The prior of log(ratio), see NoiseCheckOptions.
class RatioPrior {
 public:
  explicit RatioPrior(double typical_ratio) : sigma_(std::log(typical_ratio)) {}

  /// log integral of the prior with a normal density about u.
  double Log(double u, double variance) const;

 private:
  double sigma_;
};

/// One level for all, against the assumed one.
double EvidenceOfLevel(const LogLevel& level, const RatioPrior& prior);

/// Levels that scatter about a common one, by an unknown spread.
double EvidenceOfDifferentLevels(const std::vector<LogLevel>& levels, const RatioPrior& prior);

/// White noise that is added to that of one triad: the variance theta in units of the assumed one.
class Addition {
 public:
  Addition(double typical_sigma, double assumed_sigma, double spread_decades);

  /// log integral of L(base (1 + theta)) / L(base) over the prior; the energy in units of base.
  double Evidence(const BandEnergy& energy, double base) const;

 private:
  /// Of the distance of log(theta) from the middle of the prior.
  double LogPrior(double distance) const;

  double typical_log_;
  double spread2_;
  double log_norm_;
};

/// Likelihood of the best addition.
double BestAddition(const BandEnergy& energy);

}  // namespace dn
