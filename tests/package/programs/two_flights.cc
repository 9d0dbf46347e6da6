// Two simulated flights with one boresight: each is adjusted, and both are solved as one network.
#include <dn/diagnosis/solution.h>
#include <dn/sim/simulate.h>
#include <dn/solvers/solve.h>

#include "check.h"

namespace {

dn::SimulatedFlight Fly(int seed) {
  dn::Scenario scenario = dn::ReadScenario("lar2");
  scenario.plan.warm_up_s = 60.0;
  scenario.imu.rate_hz = 100.0;
  scenario.pairs.count = 300;
  dn::SimulateOptions options;
  options.seed = seed;
  return dn::Simulate(scenario, options);
}

}  // namespace

int main() {
  const dn::SimulatedFlight monday = Fly(1), tuesday = Fly(2);
  const dn::Solution one(monday.flight), two(tuesday.flight);
  dn::Network both;
  both.Append(one.network().net(), "monday/", {"boresight"});
  both.Append(two.network().net(), "tuesday/", {"boresight"});
  const dn::SolveSummary report = dn::Solve(both, {.sigma_tolerance = 1e-3});
  const auto boresight = both.Find<dn::LeftRotation>("boresight");
  const Eigen::Vector3d sigma_rad = dn::MarginalSigma(both, boresight);
  const Eigen::Quaterniond truth = dn::Exp(monday.boresight_rad);
  const Eigen::Vector3d error_rad = dn::Log(both.Value(boresight) * truth.conjugate());

  bool good = report.converged;
  for (int i = 0; i < 3; ++i) {
    const double one_rad = one.Boresight().sigma_rad()[i], two_rad = two.Boresight().sigma_rad()[i];
    // Two flights that share only the boresight: their information matrices add.
    const double expected_rad =
        1.0 / std::sqrt(1.0 / (one_rad * one_rad) + 1.0 / (two_rad * two_rad));
    good = Between("sigma / expected", sigma_rad[i] / expected_rad, 0.9, 1.1) && good;
    good = Agrees("boresight", error_rad[i], 0.0, sigma_rad[i]) && good;
  }
  return good ? 0 : 1;
}
