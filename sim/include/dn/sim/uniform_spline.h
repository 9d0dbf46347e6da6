#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Quintic B-spline with uniformly spaced knots: four times continuously differentiable.
///
/// The spline smooths its control points and does not interpolate them. It reproduces a straight,
/// evenly sampled line exactly; in a curve it deviates to the inside by a quarter of the
/// acceleration times step_s squared.
class UniformSpline {
 public:
  /// Position (m) in rows 0..2; roll, pitch, heading (rad, continuous) in rows 3..5.
  using Vector = Eigen::Matrix<double, 6, 1>;

  /// Value and derivatives with respect to time.
  struct Sample {
    Vector value;
    Vector first;
    Vector second;
  };

  /// Creates a spline whose control point i is at the time begin_s + i step_s. Throws InvalidInput
  /// for fewer than six control points or a step that is not positive.
  UniformSpline(double begin_s, double step_s, std::vector<Vector> control);

  /// Time span in which all derivatives are defined.
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
