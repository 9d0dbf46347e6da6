#pragma once

#include <dn/sim/disturbance.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Table of a disturbance over a time span, much faster than the sum of waves. It contains sixteen
/// samples per second with two derivatives, interpolated by quintic polynomials. The interpolation
/// has two continuous derivatives and represents waves of 1 Hz with an error of 1e-7.
class DisturbanceTable {
 public:
  struct Sample {
    /// Lead (s), height (m), roll, pitch, heading (rad) as in Disturbance, and their derivatives.
    Eigen::Matrix<double, 5, 1> value, first, second;
  };

  /// Creates a table for times in [0, duration_s], and one step before and after.
  DisturbanceTable(const Disturbance& disturbance, double duration_s);

  Sample At(double t_s) const;

 private:
  /// Value, first and second derivative with respect to time in steps.
  using Node = Eigen::Matrix<double, 5, 3>;
  std::vector<Node> nodes_;  // the first node is one step before 0
};

}  // namespace dn
