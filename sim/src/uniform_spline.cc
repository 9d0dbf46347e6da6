#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/sim/uniform_spline.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace dn {
namespace {

using Weights = Eigen::Matrix<double, 6, 1>;

// Row i contains the coefficients of 1, x, .., x^5 (times 120) of the weight of control point i.
// The control points are the six around the knot interval; x is in [0, 1].
const Eigen::Matrix<double, 6, 6>& Basis() {
  static const Eigen::Matrix<double, 6, 6> basis = [] {
    Eigen::Matrix<double, 6, 6> B;
    B << 1, -5, 10, -10, 5, -1,    //
        26, -50, 20, 20, -20, 5,   //
        66, 0, -60, 0, 30, -10,    //
        26, 50, 20, -20, -20, 10,  //
        1, 5, 10, 10, 5, -5,       //
        0, 0, 0, 0, 0, 1;
    return Eigen::Matrix<double, 6, 6>(B / 120.0);
  }();
  return basis;
}

}  // namespace

UniformSpline::UniformSpline(double begin_s, double step_s, std::vector<Vector> control)
    : begin_s_(begin_s), step_s_(step_s), control_(std::move(control)) {
  if (control_.size() < 6) throw InvalidInput("a spline needs at least 6 control points");
  if (!(step_s_ > 0.0)) throw InvalidInput("the step of a spline must be positive");
}

UniformSpline::Sample UniformSpline::At(double t_s) const {
  if (!(t_s >= t_begin_s() && t_s <= t_end_s())) {
    throw InvalidInput("time " + FormatDouble(t_s) + " s is outside the path, which spans " +
                       FormatDouble(t_begin_s()) + " to " + FormatDouble(t_end_s()) + " s");
  }
  const double knots = (t_s - begin_s_) / step_s_;
  const double last = static_cast<double>(control_.size()) - 4.0;
  const double knot = std::clamp(std::floor(knots), 2.0, last);
  const double x = knots - knot;
  Weights value, first, second;
  value << 1.0, x, x * x, x * x * x, x * x * x * x, x * x * x * x * x;
  first << 0.0, 1.0, 2.0 * x, 3.0 * x * x, 4.0 * x * x * x, 5.0 * x * x * x * x;
  second << 0.0, 0.0, 2.0, 6.0 * x, 12.0 * x * x, 20.0 * x * x * x;
  const Weights w0 = Basis() * value;
  const Weights w1 = Basis() * first / step_s_;
  const Weights w2 = Basis() * second / (step_s_ * step_s_);
  Sample sample{Vector::Zero(), Vector::Zero(), Vector::Zero()};
  const Vector* c = control_.data() + static_cast<std::ptrdiff_t>(knot) - 2;
  for (int i = 0; i < 6; ++i) {
    sample.value += w0[i] * c[i];
    sample.first += w1[i] * c[i];
    sample.second += w2[i] * c[i];
  }
  return sample;
}

}  // namespace dn
