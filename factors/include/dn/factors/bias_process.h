#pragma once

#include <dn/block.h>
#include <dn/factor.h>

#include <Eigen/Core>

namespace dn {

/// One step of a first-order process on three independent axes.
///
///   r = (x_{k+1} - phi x_k) / sqrt(q)                               [3], unitless
///
///   block | symbol  | stored | tangent | meaning
///   ------|---------|--------|---------|-----------------------------------------
///     0   | x_k     |   3    |    3    | process at the start of the step
///     1   | x_{k+1} |   3    |    3    | process at the end, in the unit of x_k
///
/// Jacobians:  -phi / sqrt(q) I,  1 / sqrt(q) I. Degenerate when: no other factor constrains a
/// block of the process. Give the first block of a random walk a prior, and that of a Gauss-Markov
/// process its stationary prior N(0, sigma^2).
class FirstOrderStep : public Factor<FirstOrderStep, 3, Vec<3>, Vec<3>> {
 public:
  template <class T>
  bool Residual(const T* x_k_data, const T* x_next_data, T* r_data) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vec3> x_k(x_k_data), x_next(x_next_data);
    Eigen::Map<Vec3> r(r_data);
    r = (x_next - T(phi_) * x_k) * T(inverse_sqrt_q_);
    return true;
  }

  bool Evaluate(double const* const* x, double* r, double** J) const override;

  /// Returns the transition factor phi from x_k to x_{k+1}.
  double phi() const { return phi_; }

 protected:
  /// Creates a step with transition factor phi and driving-noise variance q. Throws InvalidInput
  /// unless q is positive and finite.
  FirstOrderStep(double phi, double q);

 private:
  double phi_;
  double inverse_sqrt_q_;
};

/// Step of a Gauss-Markov process: phi = exp(-dt / tau), q = sigma^2 (1 - exp(-2 dt / tau)), which
/// is exact for every dt.
class GaussMarkovEdge final : public FirstOrderStep {
 public:
  /// Creates the step; sigma is the stationary standard deviation in the unit of the process.
  /// Throws InvalidInput unless sigma, tau_s and dt_s are positive and finite.
  GaussMarkovEdge(double sigma, double tau_s, double dt_s);
};

/// Step of a random walk: phi = 1, q = density^2 dt.
class RandomWalkEdge final : public FirstOrderStep {
 public:
  /// Creates the step; the density is in the unit of the process per square root of a second.
  /// Throws InvalidInput unless density and dt_s are positive and finite.
  RandomWalkEdge(double density, double dt_s);
};

}  // namespace dn
