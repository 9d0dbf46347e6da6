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

/// Returns the overlapping Allan variance of evenly spaced mean rates. The cluster times are
/// dt 2^k, up to a fifth of the record. With theta the running sum times dt, and m = tau / dt:
///
///   V(tau) = sum_k (theta_{k+2m} - 2 theta_{k+m} + theta_k)^2 / (2 tau^2 (n - 2m + 1))
///
/// The degrees of freedom are those of white noise (Howe, Allan, Barnes 1981). Throws InvalidInput
/// for fewer than 100 values, a value that is not finite, or a dt_s that is not positive.
std::vector<AllanPoint> AllanVariance(const std::vector<double>& rates, double dt_s);

/// Returns the mean of several curves with the same cluster times. One noise model for all axes has
/// to fit this mean.
std::vector<AllanPoint> MeanCurve(const std::vector<std::vector<AllanPoint>>& curves);

/// A fitted quantity with its standard deviation.
struct NoiseTerm {
  double value = 0.0;
  double sigma = 0.0;
};

/// Noise terms fitted to an Allan variance curve. Terms that the curve does not support are absent.
///
///   V(tau) = N^2/tau + GM(tau; s, T) + K^2 tau/3,
///   GM(tau; s, T) = 2 s^2 T/tau (1 - T/(2 tau) (3 - 4 e^{-tau/T} + e^{-2 tau/T}))
///
/// Source: IEEE Std 952. Units: s has the unit of the data, N that unit times sqrt(s), and K that
/// unit per sqrt(s).
struct NoiseFit {
  std::optional<NoiseTerm> quantisation;        ///< Q
  std::optional<NoiseTerm> white;               ///< N
  std::optional<NoiseTerm> gauss_markov;        ///< s
  std::optional<NoiseTerm> gauss_markov_tau_s;  ///< T
  std::optional<NoiseTerm> random_walk;         ///< K
  double chi2 = 0.0;
  int dof = 0;               ///< points minus parameters
  double floor = 0.0;        ///< smallest Allan deviation
  double floor_tau_s = 0.0;  ///< cluster time of the smallest deviation
  /// Longest cluster time of the curve; slower terms cannot be separated.
  double longest_tau_s = 0.0;

  double Variance(double tau_s) const;  ///< Allan variance of the fitted model

  /// Returns the terms as the noise model of one triad.
  SensorNoise ToSensorNoise() const;
};

/// Returns the Allan variance of a Gauss-Markov process with standard deviation 1.
double GaussMarkovAllanVariance(double tau_s, double correlation_s);

/// Fits the terms by weighted least squares to the logarithm of the curve. Every term is positive.
/// Cluster times below ten samples are not used, because filters and resolution change the noise
/// there. The relative sigma of a point is at least 2 %, because sensors do not follow the terms
/// more closely. A term is kept if it lowers chi-square by more than the 99.9 % quantile. Throws
/// InvalidInput for fewer than four usable points.
NoiseFit FitNoise(const std::vector<AllanPoint>& curve);

}  // namespace dn
