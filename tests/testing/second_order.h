#pragma once

#include <dn/builder/process_chain.h>
#include <dn/network.h>

#include <Eigen/Core>
#include <cmath>
#include <string>

namespace dn::testing {

/// Transition over dt_s of the state (value, rate) of a critically damped second-order process, and
/// its driving noise. Sigma is the standard deviation, omega the natural frequency, rad/s.
struct SecondOrderStep {
  Eigen::Matrix2d Phi, Q;

  SecondOrderStep(double sigma, double omega, double dt_s) {
    const double a = omega * dt_s;
    Phi << 1.0 + a, dt_s, -omega * a, 1.0 - a;
    Phi *= std::exp(-a);
    const Eigen::Matrix2d P = Stationary(sigma, omega);
    Q = P - Phi * P * Phi.transpose();
  }

  static Eigen::Matrix2d Stationary(double sigma, double omega) {
    return Eigen::Vector2d(sigma * sigma, sigma * sigma * omega * omega).asDiagonal();
  }
};

/// Returns the covariance of three independent axes, in the order value (3), rate (3).
inline Eigen::Matrix<double, 6, 6> ThreeAxes(const Eigen::Matrix2d& C) {
  Eigen::Matrix<double, 6, 6> six;
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k)
      six.block<3, 3>(3 * i, 3 * k) = C(i, k) * Eigen::Matrix3d::Identity();
  }
  return six;
}

/// Adds the prior and the transitions of the process to a chain; the rates are blocks of their own.
inline void AddSecondOrder(const ProcessChain& chain, double sigma, double omega, Network* net) {
  std::vector<Block<Vec<3>>> rates;
  for (std::size_t k = 0; k < chain.blocks.size(); ++k) {
    rates.push_back(
        net->AddVector<3>(chain.name + " rate/" + std::to_string(k), Eigen::Vector3d::Zero()));
  }
  const auto stacked = [](const auto& x, const auto& v) {
    Eigen::Matrix<typename std::decay_t<decltype(x)>::Scalar, 6, 1> state;
    state << x, v;
    return state;
  };
  net->Add(stacked, Noise<6>::Covariance(ThreeAxes(SecondOrderStep::Stationary(sigma, omega))),
           chain.blocks.front(), rates.front());
  for (std::size_t k = 0; k + 1 < rates.size(); ++k) {
    const SecondOrderStep step(sigma, omega, chain.t_mid_s[k + 1] - chain.t_mid_s[k]);
    const Eigen::Matrix2d Phi = step.Phi;
    net->Add(
        [=](const auto& x, const auto& v, const auto& x_next, const auto& v_next) {
          return stacked((x_next - Phi(0, 0) * x - Phi(0, 1) * v).eval(),
                         (v_next - Phi(1, 0) * x - Phi(1, 1) * v).eval());
        },
        Noise<6>::Covariance(ThreeAxes(step.Q)), chain.blocks[k], rates[k], chain.blocks[k + 1],
        rates[k + 1]);
  }
}

}  // namespace dn::testing
