#pragma once

#include <dn/eigen_alignment.h>
#include <dn/imu/imu_model.h>

#include <Eigen/Core>
#include <cstdint>
#include <string_view>

namespace dn {

class Random;

/// Simulates one axis of a slowly varying sensor error in continuous time. Each step draws the
/// process at the end of the sample interval and its mean over the interval, from their exact joint
/// covariance. An integrating sensor adds this mean.
///
///   dx = -x/tau dt + sigma sqrt(2/tau) dW  (Gauss-Markov),  dx = sigma dW  (random walk),  dx = 0
///
/// A Gauss-Markov process starts from its stationary distribution, a random walk starts at zero.
class ErrorProcess {
 public:
  /// Throws InvalidInput unless dt_s is positive.
  ErrorProcess(const BiasProcess& model, double dt_s, Random& random);

  /// Advances by dt_s and returns the mean over the interval, in the unit of the model.
  double NextMean(Random& random);

  /// Returns the process at the end of the last interval.
  double value() const { return value_; }

 private:
  double value_ = 0.0;
  double decay_ = 1.0;      // value' = decay value + ...
  double mean_gain_ = 1.0;  // mean = mean_gain value + ...
  // Cholesky factor of the covariance of (value', mean) given value.
  Eigen::Matrix2d L_ = Eigen::Matrix2d::Zero();
};

/// Returns the covariance of (x(dt), mean of x over dt) given x(0).
Eigen::Matrix2d IntervalCovariance(const BiasProcess& model, double dt_s);

}  // namespace dn
