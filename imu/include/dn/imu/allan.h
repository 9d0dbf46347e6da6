#pragma once

#include <dn/imu/imu_model.h>

#include <optional>
#include <string>
#include <vector>

namespace dn {

/// One point of an Allan variance curve.
struct AllanPoint {
  double tau_s = 0.0;
  double variance = 0.0;  ///< in the unit of the data, squared
  double dof = 0.0;       ///< equivalent degrees of freedom of the estimate

  double deviation() const;
  double sigma_of_deviation() const;  ///< deviation / sqrt(2 dof)
};

/// Overlapping Allan variance of evenly spaced mean rates at cluster times dt 2^k, up to a fifth of
/// the record; with theta the running sum times dt, m = tau / dt:
///
///   V(tau) = sum_k (theta_{k+2m} - 2 theta_{k+m} + theta_k)^2 / (2 tau^2 (n - 2m + 1))
///
/// The degrees of freedom are those of white noise (Howe, Allan, Barnes 1981). Throws InvalidInput
/// for fewer than 100 values, a value that is not finite, or a dt_s that is not positive.
std::vector<AllanPoint> AllanVariance(const std::vector<double>& rates, double dt_s);

/// Mean of several curves on the same cluster times: what one model for all axes has to explain.
std::vector<AllanPoint> MeanCurve(const std::vector<std::vector<AllanPoint>>& curves);

/// A fitted quantity with its standard deviation.
struct NoiseTerm {
  double value = 0.0;
  double sigma = 0.0;
};

/// Noise terms behind an Allan variance curve; terms that the curve does not support are absent.
///
///   V(tau) = N^2/tau + GM(tau; s, T) + K^2 tau/3,
///   GM(tau; s, T) = 2 s^2 T/tau (1 - T/(2 tau) (3 - 4 e^{-tau/T} + e^{-2 tau/T}))
///
/// (IEEE Std 952). Units: those of the data for s; times sqrt(s) for N, per sqrt(s) for K.
struct NoiseFit {
  std::optional<NoiseTerm> quantisation;        ///< Q
  std::optional<NoiseTerm> white;               ///< N
  std::optional<NoiseTerm> gauss_markov;        ///< s
  std::optional<NoiseTerm> gauss_markov_tau_s;  ///< T
  std::optional<NoiseTerm> random_walk;         ///< K
  double chi2 = 0.0;
  int dof = 0;                 ///< points minus parameters
  double floor = 0.0;          ///< smallest Allan deviation
  double floor_tau_s = 0.0;    ///< where
  double longest_tau_s = 0.0;  ///< of the curve; slower terms cannot be told apart

  double Variance(double tau_s) const;  ///< of the fitted model

  /// The terms as a model of one triad.
  SensorNoise ToSensorNoise() const;
};

/// Allan variance of a Gauss-Markov process of standard deviation 1.
double GaussMarkovAllanVariance(double tau_s, double correlation_s);

/// Identifies the terms by weighted least squares on the logarithm of the curve, from ten samples
/// on (below, filters and resolution shape the noise) and no better than 2 % (no sensor follows the
/// terms more closely); every term is positive. A term is kept when it lowers chi-square by more
/// than its 99.9 % quantile. Throws InvalidInput for fewer than four such points.
NoiseFit FitNoise(const std::vector<AllanPoint>& curve);

}  // namespace dn
