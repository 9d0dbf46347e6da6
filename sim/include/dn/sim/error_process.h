#pragma once

#include <dn/imu/imu_model.h>

#include <Eigen/Core>
#include <cstdint>
#include <string_view>

namespace dn {

class Random;

/// One axis of a slowly varying sensor error, simulated in continuous time: each step draws the
/// process at the end of the sample interval jointly with its mean over the interval, which is what
/// an integrating sensor adds, from their exact covariance.
///
///   dx = -x/tau dt + sigma sqrt(2/tau) dW  (Gauss-Markov),  dx = sigma dW  (random walk),  dx = 0
///
/// A Gauss-Markov process starts from its stationary distribution, a random walk at zero.
class ErrorProcess {
 public:
  /// Throws InvalidInput unless dt_s is positive.
  ErrorProcess(const BiasProcess& model, double dt_s, Random& random);

  /// Advances by dt_s; the mean over the interval, in the model's unit.
  double NextMean(Random& random);

  /// The process now (at the end of the last interval).
  double value() const { return value_; }

 private:
  double value_ = 0.0;
  double decay_ = 1.0;                           // value' = decay value + ...
  double mean_gain_ = 1.0;                       // mean = mean_gain value + ...
  Eigen::Matrix2d L_ = Eigen::Matrix2d::Zero();  // of (value', mean) given value
};

/// Covariance of (x(dt), mean of x over dt) given x(0).
Eigen::Matrix2d IntervalCovariance(const BiasProcess& model, double dt_s);

}  // namespace dn
