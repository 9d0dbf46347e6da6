#include <dn/error.h>
#include <dn/factors/bias_process.h>
#include <dn/imu/imu_model.h>

#include <cmath>
#include <string>

namespace dn {
namespace {

double CheckedPositive(double value, const std::string& what) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw InvalidInput(what + " is " + std::to_string(value) + ", must be positive and finite");
  }
  return value;
}

GaussMarkovStep GaussMarkov(double sigma, double tau_s, double dt_s) {
  return DiscretiseGaussMarkov(CheckedPositive(sigma, "sigma of a Gauss-Markov process"),
                               CheckedPositive(tau_s, "correlation time of a Gauss-Markov process"),
                               CheckedPositive(dt_s, "time step of a Gauss-Markov process"));
}

}  // namespace

FirstOrderStep::FirstOrderStep(double phi, double q)
    : phi_(phi),
      inverse_sqrt_q_(1.0 / std::sqrt(CheckedPositive(q, "variance of a process step"))) {}

bool FirstOrderStep::Evaluate(double const* const* x, double* r, double** J) const {
  const Eigen::Matrix3d J_next = Eigen::Vector3d::Constant(inverse_sqrt_q_).asDiagonal();
  Put<0>(x, J, -phi_ * J_next);
  Put<1>(x, J, J_next);
  return Residual(x[0], x[1], r);
}

GaussMarkovEdge::GaussMarkovEdge(double sigma, double tau_s, double dt_s)
    : FirstOrderStep(GaussMarkov(sigma, tau_s, dt_s).phi, GaussMarkov(sigma, tau_s, dt_s).q) {}

RandomWalkEdge::RandomWalkEdge(double density, double dt_s)
    : FirstOrderStep(1.0, std::pow(CheckedPositive(density, "density of a random walk"), 2) *
                              CheckedPositive(dt_s, "time step of a random walk")) {}

}  // namespace dn
