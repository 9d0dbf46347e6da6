#pragma once

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Quintic B-spline with uniformly spaced knots: four times continuously differentiable.
///
/// Control points are not interpolated but smoothed: a straight, evenly sampled line is reproduced
/// exactly, a curve is cut inside by a quarter of its acceleration times step_s squared.
class UniformSpline {
 public:
  /// Position (m) in rows 0..2, roll, pitch, heading (rad, continuous) in rows 3..5.
  using Vector = Eigen::Matrix<double, 6, 1>;

  /// Value and derivatives with respect to time.
  struct Sample {
    Vector value;
    Vector first;
    Vector second;
  };

  /// Control point i stands at begin_s + i step_s. Throws InvalidInput for fewer than six control
  /// points or a step that is not positive.
  UniformSpline(double begin_s, double step_s, std::vector<Vector> control);

  /// Times that every derivative is defined at.
  double t_begin_s() const { return begin_s_ + 2.0 * step_s_; }
  double t_end_s() const {
    return begin_s_ + (static_cast<double>(control_.size()) - 3.0) * step_s_;
  }

  /// Throws InvalidInput outside [t_begin_s, t_end_s].
  Sample At(double t_s) const;

 private:
  double begin_s_;
  double step_s_;
  std::vector<Vector> control_;
};

}  // namespace dn
