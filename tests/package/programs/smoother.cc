// A smoother for a point with constant velocity. Its NEES over many runs tests the covariances.
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <random>
#include <vector>

#include "check.h"

namespace {

constexpr int kSteps = 50, kRuns = 200;
constexpr double kSigma_m = 0.5;

/// Returns the normalised squared error of the state in the middle, of dimension 2.
double Nees(unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  const Eigen::Matrix2d F{{1.0, 1.0}, {0.0, 1.0}};
  const Eigen::Matrix2d Q{{1.0 / 3.0, 0.5}, {0.5, 1.0}};  // white acceleration over 1 s
  const dn::Noise<2> motion = dn::Noise<2>::Covariance(0.01 * Q);
  const Eigen::Matrix2d root = motion.covariance().llt().matrixL();

  dn::Network net;
  std::vector<dn::Block<dn::Vec<2>>> states;
  std::vector<Eigen::Vector2d> truth{{0.0, 1.0}};
  for (int k = 0; k < kSteps; ++k) {
    if (k > 0) {
      truth.push_back(F * truth.back() + root * Eigen::Vector2d(normal(rng), normal(rng)));
    }
    states.push_back(net.AddVector<2>("state " + std::to_string(k), Eigen::Vector2d::Zero()));
    const double measured_m = truth.back()[0] + kSigma_m * normal(rng);
    net.Add([=](const auto& x) { return x[0] - measured_m; }, dn::Noise<1>::Sigma(kSigma_m),
            states.back());
    if (k == 0) continue;
    net.Add([=](const auto& a, const auto& b) { return (b - F * a).eval(); }, motion,
            states[states.size() - 2], states.back());
  }
  if (!dn::Solve(net).converged) return NAN;
  const auto middle = states[kSteps / 2];
  const Eigen::Vector2d error = net.Value(middle) - truth[kSteps / 2];
  return error.dot(dn::MarginalCovariance(net, middle).inverse() * error);
}

}  // namespace

int main() {
  double sum = 0.0;
  for (unsigned seed = 0; seed < kRuns; ++seed) sum += Nees(seed);
  // The mean has expectation 2 and standard deviation sqrt(4 / kRuns).
  const double bound = 4.0 * std::sqrt(4.0 / kRuns);
  return Between("mean NEES", sum / kRuns, 2.0 - bound, 2.0 + bound) ? 0 : 1;
}
