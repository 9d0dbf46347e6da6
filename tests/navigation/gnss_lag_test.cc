#include <dn/navigation/gnss_lag.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "testing/short_flights.h"
#include "testing/tolerances.h"

namespace dn::navigation_test {

namespace fs = std::filesystem;

using testing::AircraftScenario;
using testing::DroneScenario;
using testing::kSigmas;

/// Returns a flight without pairs.
Flight FlyWithout(Scenario scenario, double sigma_m) {
  scenario.pairs.count = 0;
  scenario.gnss.sigma_enu_m = sigma_m * Eigen::Vector3d(1.0, 1.0, 1.5);
  return Simulate(scenario, {.seed = 3}).flight;
}

Flight Late(Flight flight, double lag_s) {
  for (MapGnssEpoch& epoch : flight.gnss->epochs) epoch.t_s += lag_s;
  return flight;
}

void ExpectLag(const Flight& flight, double lag_s) {
  SCOPED_TRACE(lag_s);
  const auto found = FindGnssLag(flight);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->lag_s, lag_s, kSigmas * found->sigma_s);
  EXPECT_LT(found->sigma_s, 0.5);
  EXPECT_TRUE(found->certain);
}

TEST(GnssLag, IsFoundWithinItsSigma) {
  for (const double sigma_m : {0.015, 2.0}) {
    SCOPED_TRACE(sigma_m);
    const Flight drone = FlyWithout(DroneScenario(), sigma_m);
    for (const double lag_s : {5.0, -10.0, 30.0}) ExpectLag(Late(drone, lag_s), lag_s);
    ExpectLag(Late(FlyWithout(AircraftScenario(), sigma_m), 10.0), 10.0);
  }
}

// An adjustment finds lags below 2 s.
TEST(GnssLag, RightTagsAndShortLagsFit) {
  for (const double sigma_m : {0.015, 2.0}) {
    const Flight flight = FlyWithout(AircraftScenario(), sigma_m);
    for (const double lag_s : {0.0, 0.1, -1.0}) {
      SCOPED_TRACE(lag_s);
      EXPECT_FALSE(FindGnssLag(Late(flight, lag_s)));
      EXPECT_TRUE(GnssTagsFit(Late(flight, lag_s)));
    }
  }
}

TEST(GnssLag, AnotherFlightDoesNotFit) {
  Flight flight = FlyWithout(DroneScenario(), 0.015);
  const Flight other = FlyWithout(AircraftScenario(), 0.015);
  flight.imu = other.imu;
  const auto found = FindGnssLag(flight);
  EXPECT_TRUE(!found || !found->certain);
  EXPECT_FALSE(GnssTagsFit(flight));
}

struct MeasuredLog {
  const char* name;
  double own_s;  // lag of the log as it is, within 0.1 s
};

class GnssLagOfMeasuredLogs : public ::testing::TestWithParam<MeasuredLog> {};

INSTANTIATE_TEST_SUITE_P(Logs, GnssLagOfMeasuredLogs,
                         ::testing::Values(MeasuredLog{"thor75", 0.05}, MeasuredLog{"walk", 0.01},
                                           MeasuredLog{"psins-car", -0.04},
                                           MeasuredLog{"inertialnav-testlog2", 0.25}),
                         [](const auto& tested) {
                           std::string name = tested.param.name;
                           std::erase(name, '-');
                           return name;
                         });

TEST_P(GnssLagOfMeasuredLogs, IsFound) {
  const fs::path folder = fs::path(DN_SHARED_DATA_DIR) / "data" / GetParam().name;
  if (!fs::exists(folder)) GTEST_SKIP() << "no real data in " << folder;
  const Flight flight = ReadFlight(folder, {.imu = true, .gnss = true});
  EXPECT_FALSE(FindGnssLag(flight));
  EXPECT_TRUE(GnssTagsFit(flight));
  for (const double lag_s : {10.0, -10.0}) {
    SCOPED_TRACE(lag_s);
    const auto found = FindGnssLag(Late(flight, lag_s));
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->certain || lag_s < 0.0);  // one log is too short for the second shift
    EXPECT_NEAR(found->lag_s, lag_s + GetParam().own_s, kSigmas * found->sigma_s);
  }
}

}  // namespace dn::navigation_test
