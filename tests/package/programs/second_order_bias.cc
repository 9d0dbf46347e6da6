// A bias that is a second-order Gauss-Markov process, with the numbers of a stationary start.
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <random>
#include <vector>

#include "check.h"

namespace {

constexpr double kOmega = 0.2, kDamping = 0.5, kSigma = 1.0, kReading = 0.3, kStep_s = 1.0;
constexpr int kSteps = 400;

/// Returns exp(A t) of the process b'' + 2 damping omega b' + omega^2 b = w.
Eigen::Matrix2d Transition() {
  const double decay = kDamping * kOmega, rate = kOmega * std::sqrt(1.0 - kDamping * kDamping);
  const double c = std::cos(rate * kStep_s), s = std::sin(rate * kStep_s) / rate;
  const Eigen::Matrix2d A{{0.0, 1.0}, {-kOmega * kOmega, -2.0 * decay}};
  return std::exp(-decay * kStep_s) *
         (c * Eigen::Matrix2d::Identity() + s * (A + decay * Eigen::Matrix2d::Identity()));
}

}  // namespace

int main() {
  const Eigen::Matrix2d F = Transition();
  const Eigen::Matrix2d P =
      Eigen::Vector2d(kSigma * kSigma, std::pow(kSigma * kOmega, 2)).asDiagonal();
  const dn::Noise<2> start = dn::Noise<2>::Covariance(P);
  const dn::Noise<2> step = dn::Noise<2>::Covariance(P - F * P * F.transpose());
  const Eigen::Matrix2d root = step.covariance().llt().matrixL();
  std::mt19937 rng(3);
  std::normal_distribution<double> normal;

  dn::Network net;
  std::vector<dn::Block<dn::Vec<2>>> states;
  std::vector<Eigen::Vector2d> truth{{kSigma * normal(rng), kSigma * kOmega * normal(rng)}};
  for (int k = 0; k < kSteps; ++k) {
    states.push_back(net.AddVector<2>("bias " + std::to_string(k), Eigen::Vector2d::Zero()));
    if (k == 0) {
      net.Add([](const auto& x) { return x.eval(); }, start, states[0]);
    } else {
      truth.push_back(F * truth.back() + root * Eigen::Vector2d(normal(rng), normal(rng)));
      net.Add([=](const auto& a, const auto& b) { return (b - F * a).eval(); }, step,
              states[states.size() - 2], states.back());
    }
    if (k % 4 != 0) continue;  // a reading every 4 s
    const double reading = truth.back()[0] + kReading * normal(rng);
    net.Add([=](const auto& x) { return x[0] - reading; }, dn::Noise<1>::Sigma(kReading),
            states.back());
  }
  bool good = dn::Solve(net).converged;
  dn::Marginals marginals(net);
  marginals.ComputeSelectedInverse();
  double nees = 0.0;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const Eigen::Vector2d error = net.Value(states[k]) - truth[k];
    nees += error.dot(marginals.Covariance(states[k]).inverse() * error) / kSteps;
  }
  good = Between("mean NEES", nees, 1.5, 2.5) && good;
  return Between("sigma", marginals.Sigma(states[kSteps / 2])[0], 0.1, kReading) && good ? 0 : 1;
}
