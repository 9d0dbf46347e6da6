// An error process of one's own in a flight: a second-order Gauss-Markov process.
//
// The gyros of a simulated flight get an error with a smooth random course. It is estimated first
// as a first-order process, then as the process that it is. Prints errors and sigmas of the gyro
// bias. Fails unless the second is more accurate and its errors agree with its sigmas.
#include <dn/builder/stationary_process.h>
#include <dn/diagnosis/solution.h>
#include <dn/sim/random.h>
#include <dn/sim/simulate.h>

#include <cstdio>

/// Adjusts the flight. Prints and returns the rms of error and error / sigma of the gyro bias.
Eigen::Vector2d Adjust(const char* name, const dn::SimulatedFlight& sim,
                       const dn::ProcessModel& model, const dn::OwnErrors& truth) {
  const dn::Solution solution(sim.flight,
                              {.with_pairs = false, .network = {.process_model = model}});
  Eigen::Vector2d sum2(0.0, 0.0);
  for (const dn::BiasEstimate& bias : solution.trajectory().biases) {
    const Eigen::Vector3d error = bias.gyro_radps - truth.gyro_radps(bias.t_s);
    sum2 += Eigen::Vector2d{error.squaredNorm(),
                            error.cwiseQuotient(bias.sigma_gyro_radps).squaredNorm()};
  }
  const auto n = static_cast<double>(3 * solution.trajectory().biases.size());
  const Eigen::Vector2d rms = (sum2 / n).cwiseSqrt();
  std::printf("%s: error %.2f deg/h rms, error / sigma %.2f rms\n", name,
              dn::DegPerHourFromRadps(rms[0]), rms[1]);
  return rms;
}

int main() {
  const double sigma = dn::RadpsFromDegPerHour(20.0), omega = 0.1;
  dn::Scenario scenario = dn::ReadScenario("lar2", {"plan.warm_up_s=60", "imu.rate_hz=100"});
  scenario.pairs.count = 0;
  dn::Random random(1, "waves");
  std::vector<Eigen::Vector3d> error{{0, 0, 0}};
  Eigen::Vector3d rate(0, 0, 0);
  constexpr double kStep_s = 0.01;  // x'' = -2 omega x' - omega^2 x + noise, by small steps
  while (error.size() < 100000) {
    const Eigen::Vector3d noise = 2.0 * sigma * std::pow(omega, 1.5) * random.Normal3();
    rate +=
        kStep_s * (-2.0 * omega * rate - omega * omega * error.back()) + std::sqrt(kStep_s) * noise;
    error.push_back(error.back() + kStep_s * rate);
  }
  dn::SimulateOptions simulate;
  simulate.own.gyro_radps = [&](double t_s) {
    return error.at(static_cast<std::size_t>((t_s - scenario.start_s) / kStep_s));
  };
  dn::SimulatedFlight sim = dn::Simulate(scenario, simulate);
  sim.flight.config.imu->model.gyro.processes.push_back(
      {dn::BiasProcess::Type::kGaussMarkov, sigma, 2.0 / omega});

  const auto process = dn::StationaryProcess::SecondOrder(sigma, omega);
  const auto model = [&](const dn::ProcessChain& chain, dn::Network* net) {
    if (chain.name != "gyro_bias/2") return false;  // the others stay as configured
    dn::AddStationaryProcess(process, chain, net);
    return true;
  };
  const Eigen::Vector2d first = Adjust("first order ", sim, {}, simulate.own);
  const Eigen::Vector2d second = Adjust("second order", sim, model, simulate.own);
  return second[0] < first[0] && second[1] > 0.7 && second[1] < 1.4 ? 0 : 1;
}
