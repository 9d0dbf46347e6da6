#pragma once

#include <dn/builder/process_chain.h>
#include <dn/network.h>

#include <Eigen/Core>

namespace dn {

/// A stationary linear process of n states on each axis, whose first state is the error. With the
/// covariance P of the states, and F in 1/s,
///
///   s(t + dt) = Phi s(t) + w,   Phi = exp(F dt),   cov(w) = P - Phi P Phi^T,
///
/// is exact for every dt. The axes are independent and have the same process.
struct StationaryProcess {
  Eigen::MatrixXd F;
  Eigen::MatrixXd P;

  /// Returns the second-order Gauss-Markov process with critical damping, n = 2:
  ///
  ///   x'' = -2 omega x' - omega^2 x + white noise,   E[x(t) x(t + dt)] = sigma^2 (1 + a) exp(-a),
  ///
  /// with a = omega dt; sigma is in the unit of the error, omega in rad/s. Its course is smooth,
  /// while that of a first-order process is rough. Throws InvalidInput unless both are positive and
  /// finite.
  static StationaryProcess SecondOrder(double sigma, double omega);
};

/// Adds a process to the blocks of a chain: the prior P of the first states, and the transitions.
/// The states after the first are blocks "<chain>/states/<k>" of 3 (n - 1) numbers, three axes per
/// state. Use it in a ProcessModel:
///
///   options.network.process_model = [&](const dn::ProcessChain& chain, dn::Network* net) {
///     if (chain.name != "gyro_bias/1") return false;
///     dn::AddStationaryProcess(process, chain, net);
///     return true;
///   };
///
/// Throws InvalidInput if F and P are not square and of one size, or if P or the covariance of w is
/// not positive definite.
void AddStationaryProcess(const StationaryProcess& process, const ProcessChain& chain,
                          Network* net);

}  // namespace dn
