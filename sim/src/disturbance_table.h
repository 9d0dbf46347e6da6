#pragma once

#include <dn/sim/disturbance.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// A disturbance over a span of time, sampled sixteen times a second with its first two derivatives
/// and continued between the samples by quintic polynomials: twice continuously differentiable, and
/// within 1e-7 of waves of 1 Hz. Many times quicker than their sum.
class DisturbanceTable {
 public:
  struct Sample {
    /// Lead (s), height (m), roll, pitch, heading (rad), as in Disturbance; and their rates.
    Eigen::Matrix<double, 5, 1> value, first, second;
  };

  /// For times in [0, duration_s], and one step beyond either end.
  DisturbanceTable(const Disturbance& disturbance, double duration_s);

  Sample At(double t_s) const;

 private:
  /// Value, first and second derivative with respect to time in steps.
  using Node = Eigen::Matrix<double, 5, 3>;
  std::vector<Node> nodes_;  // the first one step before 0
};

}  // namespace dn
