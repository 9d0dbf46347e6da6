#include "boresight_scatter.h"

#include <dn/geo/local_frame.h>
#include <gtest/gtest.h>

#include <cmath>

#include "testing/short_flights.h"

namespace dn::diagnosis_internal {

using testing::AircraftScenario;

double FlightScatter(const std::string& effects) {
  const Flight flight = Simulate(AircraftScenario(effects), {}).flight;
  const testing::Calibration adjusted(flight);
  const auto scatter = BoresightScatter(adjusted.solution.network(), 1);
  EXPECT_TRUE(scatter.has_value());
  return scatter.value_or(std::nan(""));
}

TEST(ExcessScatter, IsWhatTheNoiseLeaves) {
  // Two values that differ by 2, with sigma 1: the contrasts are 2 / sqrt(2) in each component.
  Eigen::VectorXd values(6);
  values << 0, 0, 0, 2, 2, 2;
  const Eigen::MatrixXd C = Eigen::MatrixXd::Identity(6, 6);
  EXPECT_NEAR(ExcessScatter(values, C), 1.0, 1e-9);
  EXPECT_EQ(ExcessScatter(0.5 * values, C), 0.0);
}

TEST(ExcessScatter, DoesNotSeeWhatIsCommon) {
  Eigen::VectorXd values(9);
  values << 1, 2, 3, 1, 2, 3, 1, 2, 3;
  EXPECT_EQ(ExcessScatter(values, 1e-6 * Eigen::MatrixXd::Identity(9, 9)), 0.0);
}

TEST(BoresightScatter, IsAboutNoneWithoutAGap) { EXPECT_LT(FlightScatter("") * kDegPerRad, 0.003); }

TEST(BoresightScatter, SeesAMountThatMoves) {
  constexpr double kStep_deg = 0.05;
  const double scatter_deg =
      kDegPerRad *
      FlightScatter("effects: [{effect: boresight_step, value: [0.05, 0, 0], t0_s: 381170}]");
  EXPECT_GT(scatter_deg, 0.1 * kStep_deg);
  EXPECT_LT(scatter_deg, kStep_deg);
}

TEST(BoresightScatter, NeedsTwoPairsOfStrips) {
  Scenario scenario = AircraftScenario();
  scenario.plan.lines.pop_back();
  const Flight flight = Simulate(scenario, {}).flight;
  const testing::Calibration adjusted(flight);
  EXPECT_FALSE(BoresightScatter(adjusted.solution.network(), 1).has_value());
}

}  // namespace dn::diagnosis_internal
