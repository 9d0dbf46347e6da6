#include <dn/builder/build.h>
#include <dn/builder/flight_nodes.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <vector>

#include "builder/drone_flight.h"
#include "testing/expect_invalid.h"
#include "testing/short_flights.h"

namespace dn::builder_test {

using testing::DroneFlight;

const Solution& Solved() {
  static const Solution solution(DroneFlight().flight);
  return solution;
}

/// Returns a design with the true motion at the rate of the inertial samples.
NetworkDesign Plan() {
  NetworkDesign design;
  const ImuData& imu = *DroneFlight().flight.imu;
  design.poses.push_back(DroneFlight().truth->Pose(imu.t_begin_s()));
  for (const ImuSample& sample : imu.samples) {
    design.poses.push_back(DroneFlight().truth->Pose(sample.t_s));
  }
  return design;
}

/// Returns the drone flight without measurements except the laser vectors.
Flight WithoutData() {
  Flight flight = DroneFlight().flight;
  flight.imu.reset();
  flight.gnss.reset();
  flight.config.lidar->mounting.boresight_rad = DroneFlight().boresight_rad;
  return flight;
}

Eigen::Vector3d BoresightSigma(const FlightNetwork& network) {
  return MarginalCovariance(network.net(), network.calibration().boresight())
      .diagonal()
      .cwiseSqrt();
}

// The covariances of a plan equal those of the flight that is measured later. They do not depend on
// the measured values or on their noise.
TEST(Build, APlanForetellsTheSigmasOfTheFlight) {
  const NetworkDesign design = Plan();
  Flight plan = WithoutData();
  PlanMeasurements(design, {.imu_hz = 100.0, .gnss_hz = 2.0}, &plan);
  const FlightNetwork network = Build(plan, design);
  EXPECT_EQ(network.pairs().edges().size(), plan.pairs->pairs.size());
  const Eigen::Vector3d foretold = BoresightSigma(network),
                        found = Solved().Boresight().sigma_rad();
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(foretold[i] / found[i], 1.0, 0.02) << i;
}

// The poses, the planned readings and the equations of the network are consistent: the residuals
// vanish.
TEST(Build, PlannedReadingsFitTheirPoses) {
  const NetworkDesign design = Plan();
  Flight plan = WithoutData();
  plan.pairs.reset();
  PlanMeasurements(design, {.imu_hz = 100.0, .gnss_hz = 2.0}, &plan);
  const CostSummary summary = EvaluateCost(Build(plan, design).net());
  EXPECT_LT(2.0 * summary.cost, 0.01 * static_cast<double>(summary.residuals));
}

TEST(Build, ASolutionIsADesign) {
  const FlightNetwork& solved = Solved().network();
  NetworkDesign design;
  for (std::size_t k = 0; k < solved.nodes().size(); ++k)
    design.poses.push_back(solved.trajectory().NodePose(k));
  design.node_t_s = solved.trajectory().node_times();
  design.calibration = solved.calibration().State();
  design.gyro_bias_radps = solved.trajectory().GyroBias(design.node_t_s.front());
  design.accel_bias_mps2 = solved.trajectory().AccelBias(design.node_t_s.front());
  const FlightNetwork network = Build(DroneFlight().flight, design);
  EXPECT_EQ(network.net().num_factors(), solved.net().num_factors());
  const Eigen::Vector3d sigma = BoresightSigma(network), found = Solved().Boresight().sigma_rad();
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(sigma[i] / found[i], 1.0, 1e-3) << i;
}

TEST(Build, MeasurementsThatThereAreStay) {
  Flight flight = DroneFlight().flight;
  const std::size_t samples = flight.imu->samples.size(), epochs = flight.gnss->epochs.size();
  PlanMeasurements(Plan(), {}, &flight);
  EXPECT_EQ(flight.imu->samples.size(), samples);
  EXPECT_EQ(flight.gnss->epochs.size(), epochs);
}

TEST(Build, WhatIsMissingIsNamed) {
  const NetworkDesign design = Plan();
  Flight flight = WithoutData();
  testing::ExpectInvalid([&] { Build(flight, design); }, "PlanMeasurements", 0);
  flight.imu = DroneFlight().flight.imu;
  testing::ExpectInvalid([&] { Build(flight, design); }, "no GNSS epochs", 0);
  testing::ExpectInvalid([&] { PlanMeasurements(design, {.gnss_hz = 0.0}, &flight); }, "GNSS rate",
                         0);
  testing::ExpectInvalid([&] { PlanMeasurements(design, {.gnss_hz = 1e-6}, &flight); }, "too short",
                         0);
}

}  // namespace dn::builder_test
