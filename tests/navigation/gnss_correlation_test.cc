#include <dn/navigation/gnss_correlation.h>
#include <gtest/gtest.h>

#include "testing/short_flights.h"

namespace dn::navigation_test {

using testing::AircraftScenario;
using testing::DroneScenario;

constexpr const char* kErrors =
    "effects: [{effect: gnss_correlated_noise, value: [0.02, 0.02, 0.04, 30]}]\n";

Scenario WithoutPairs(Scenario scenario) {
  scenario.pairs.count = 0;
  return scenario;
}

GnssCorrelation Tested(const Scenario& scenario, std::uint64_t seed, double sigma_scale = 1.0,
                       const std::vector<GnssProcess>& processes = {}) {
  SimulateOptions simulate;
  simulate.seed = seed;
  SimulatedFlight sim = Simulate(WithoutPairs(scenario), simulate);
  sim.flight.config.gnss->sigma_scale = sigma_scale;
  sim.flight.config.gnss->processes = processes;
  AdjustOptions options;
  options.with_pairs = false;
  return Adjust(sim.flight, options).gnss_correlation;
}

// The false-alarm rate is 0.001 per flight. Wrong sigmas of white noise must not be taken for
// time-correlated errors.
TEST(GnssCorrelationManyRuns, IsSilentOnWhiteNoise) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    for (const Scenario& scenario : {AircraftScenario(), DroneScenario()}) {
      const GnssCorrelation test = Tested(scenario, seed);
      EXPECT_FALSE(test.significant()) << test.p_value.transpose();
      EXPECT_GT(test.process.tau_s, 0.0) << "tested";
    }
    EXPECT_FALSE(Tested(AircraftScenario(), seed, 0.6).significant());
  }
}

// The simulator shares no formula with the test. A flight of six minutes determines sigmas to a
// factor of two and correlation times to a factor of three.
TEST(GnssCorrelation, FindsTimeCorrelatedErrors) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const GnssCorrelation test = Tested(AircraftScenario(kErrors), seed);
    EXPECT_TRUE(test.significant()) << test.p_value.transpose();
    EXPECT_GT(test.process.tau_s, 10.0);
    EXPECT_LT(test.process.tau_s, 90.0);
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma_m = axis == 2 ? 0.04 : 0.02;
      EXPECT_GT(test.process.sigma_enu_m[axis], 0.5 * sigma_m);
      EXPECT_LT(test.process.sigma_enu_m[axis], 2.0 * sigma_m);
      EXPECT_GT(test.lag1[axis], test.lag1_expected[axis]);
    }
  }
}

// One in 300 such flights has a p-value below 0.001, and seven below 0.05.
TEST(GnssCorrelation, IsSilentWhereTheProcessIsStated) {
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const GnssCorrelation test =
        Tested(AircraftScenario(kErrors), seed, 1.0, {{{0.02, 0.02, 0.04}, 30.0}});
    if (test.significant()) ++alarms;
  }
  EXPECT_LE(alarms, 1);
}

}  // namespace dn::navigation_test
