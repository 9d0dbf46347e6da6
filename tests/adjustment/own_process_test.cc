// Error processes of the user's own in an adjusted flight.
#include <dn/adjustment/adjust.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "testing/second_order.h"
#include "testing/short_flights.h"
#include "testing/tolerances.h"

namespace dn::adjustment_test {

using testing::Calibration;

/// Returns the drone flight with time-correlated GNSS errors.
SimulatedFlight FlightWithGnssErrors() {
  Scenario scenario = testing::DroneScenario();
  scenario.gnss.processes = {{{0.02, 0.02, 0.03}, 60.0}};
  return testing::Fly(scenario, 2);
}

/// States a Gauss-Markov process by factors of its own, in place of those of the builder.
bool RestateGaussMarkov(const ProcessChain& chain, Network* net) {
  const double sigma = chain.process.sigma, tau_s = chain.process.tau_s;
  if (chain.process.type != BiasProcess::Type::kGaussMarkov) return false;
  net->Add([](const auto& x) { return x.eval(); }, Noise<3>::Sigma(sigma), chain.blocks.front());
  for (std::size_t k = 0; k + 1 < chain.blocks.size(); ++k) {
    const GaussMarkovStep step =
        DiscretiseGaussMarkov(sigma, tau_s, chain.t_mid_s[k + 1] - chain.t_mid_s[k]);
    net->Add([phi = step.phi](const auto& x, const auto& next) { return (next - phi * x).eval(); },
             Noise<3>::Sigma(std::sqrt(step.q)), chain.blocks[k], chain.blocks[k + 1]);
  }
  return true;
}

// The processes of gyros, accelerometers and GNSS, stated again by the user, give the same flight:
// estimates, covariances and tests.
TEST(OwnProcessManyRuns, TheSameProcessGivesTheSameAdjustment) {
  const SimulatedFlight sim = FlightWithGnssErrors();
  const Calibration plain(sim.flight);

  std::set<std::string> chains;
  AdjustOptions options;
  options.network.process_model = [&](const ProcessChain& chain, Network* net) {
    const bool own = RestateGaussMarkov(chain, net);
    if (own) chains.insert(chain.name.substr(0, chain.name.find('/')));
    return own;
  };
  const Calibration own(sim.flight, options);

  EXPECT_EQ(chains, (std::set<std::string>{"gyro_bias", "accel_bias", "gnss_error"}));
  EXPECT_LT((own.boresight.angles_rad - plain.boresight.angles_rad).norm(), 1e-9);
  EXPECT_LT((own.boresight.sigma_rad() - plain.boresight.sigma_rad()).norm(),
            1e-8 * plain.boresight.sigma_rad().norm());
  const AdjustmentFigures a = plain.solution.trajectory().figures,
                          b = own.solution.trajectory().figures;
  EXPECT_EQ(a.redundancy, b.redundancy);
  EXPECT_NEAR(a.chi2, b.chi2, 1e-6 * a.chi2);
}

// A second-order process replaces that of the GNSS error, and one more is added to the gyros. Both
// are estimated with their own blocks, and the boresight stays within its sigmas.
TEST(OwnProcess, SecondOrderProcessesAreEstimatedWithTheFlight) {
  SimulatedFlight sim = FlightWithGnssErrors();
  const double sigma_radps = RadpsFromDegPerHour(10.0), omega = 0.05;
  auto& gyro = sim.flight.config.imu->model.gyro.processes;
  const std::string added = "gyro_bias/" + std::to_string(gyro.size());
  gyro.push_back({BiasProcess::Type::kGaussMarkov, sigma_radps, 2.0 / omega});

  AdjustOptions options;
  options.network.process_model = [&](const ProcessChain& chain, Network* net) {
    if (chain.name != added && chain.name != "gnss_error/0") return false;
    testing::AddSecondOrder(chain, chain.name == added ? sigma_radps : 1.0, omega, net);
    return true;
  };
  const Calibration c(sim.flight, options);

  EXPECT_TRUE(c.adjustment.converged);
  const Network& net = c.solution.network().net();
  for (const auto& [chain, sigma] : {std::pair{added, sigma_radps}, {"gnss_error/0", 1.0}}) {
    const auto rate = net.Find<Vec<3>>(chain + " rate/3");
    const Eigen::Vector3d rate_sigma = c.marginals.Sigma(rate);
    EXPECT_GT(rate_sigma.minCoeff(), 0.0);
    EXPECT_LE(rate_sigma.maxCoeff(), sigma * omega * (1.0 + 1e-9)) << "data cannot widen a prior";
    EXPECT_NE(net.Value(rate), Eigen::Vector3d(Eigen::Vector3d::Zero()));
  }
  EXPECT_LT(c.BoresightError(sim.boresight_rad)
                .cwiseQuotient(c.boresight.sigma_rad())
                .cwiseAbs()
                .maxCoeff(),
            testing::kSigmas);
}

}  // namespace dn::adjustment_test
