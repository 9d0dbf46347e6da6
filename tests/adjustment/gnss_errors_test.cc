// Covariances over many flights with time-correlated GNSS errors, with and without the states that
// model them.
#include <dn/adjustment/gnss_errors.h>
#include <dn/adjustment/words.h>
#include <dn/distributions.h>
#include <dn/geo/local_frame.h>
#include <dn/rotation.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "testing/short_flights.h"

namespace dn::adjustment_test {

using testing::AircraftScenario;
using testing::Calibration;
using ::testing::HasSubstr;

constexpr int kFlights = 14;
const std::vector<GnssProcess> kProcesses{{{0.015, 0.015, 0.0}, 120.0}, {{0.0, 0.0, 0.03}, 60.0}};

constexpr double kTurningRad = 20.0 * kRadPerDeg;
const std::vector<GnssProcess> kByBank{{{0.06, 0.06, 0.1}, 20.0, GnssErrorGrowth::kBank}};

SimulatedFlight FlyWithGnssErrors(std::uint64_t seed,
                                  const std::vector<GnssProcess>& processes = kProcesses) {
  Scenario scenario = AircraftScenario();
  scenario.gnss.processes = processes;
  SimulateOptions options;
  options.seed = seed;
  return Simulate(scenario, options);
}

/// Squared errors over their variances, summed over all flights.
struct Nees {
  double boresight = 0.0, position = 0.0;
};

/// Returns the node in the middle of the flight, or after it within the next turn if errors grow
/// with the bank.
const NodeBlocks& TestedNode(const FlightNetwork& network, const TruthTrajectory& truth,
                             bool by_bank) {
  std::size_t k = network.nodes().size() / 2;
  const auto level = [&](double t_s) {
    return std::abs(RollPitchHeading(truth.Nav(t_s).q_nb).x()) < kTurningRad;
  };
  while (by_bank && level(network.nodes()[k].t_s)) ++k;
  return network.nodes()[k];
}

double PositionNees(const SimulatedFlight& sim, const Calibration& calibration, bool by_bank) {
  const FlightNetwork& network = *calibration.adjustment.network;
  const NodeBlocks& node = TestedNode(network, *sim.truth, by_bank);
  const Eigen::Vector3d error = network.net().Value(node.p_mb) - sim.truth->Pose(node.t_s).p_mb;
  return error.dot(calibration.marginals.Covariance(node.p_mb).ldlt().solve(error));
}

Nees FlightsNees(bool with_states, const std::vector<GnssProcess>& processes = kProcesses) {
  const bool by_bank = processes.front().growth == GnssErrorGrowth::kBank;
  Nees nees;
  for (std::uint64_t seed = 1; seed <= kFlights; ++seed) {
    SimulatedFlight sim = FlyWithGnssErrors(seed, processes);
    if (!with_states) sim.flight.config.gnss->processes.clear();
    const Calibration calibration(sim.flight);
    const bool unlike_white_noise = by_bank && !with_states;  // large errors may look like outliers
    EXPECT_TRUE(calibration.adjustment.gnss_rejected.empty() || unlike_white_noise)
        << "seed " << seed;
    const Eigen::Vector3d e = calibration.BoresightError(sim.boresight_rad);
    nees.boresight += e.dot(calibration.boresight.covariance_rad2.ldlt().solve(e));
    nees.position += PositionNees(sim, calibration, by_bank);
  }
  return nees;
}

/// Returns the numbers of a row that commas separate.
std::vector<double> Numbers(const std::string& row) {
  std::vector<double> numbers;
  std::istringstream cells(row);
  std::string cell;
  while (std::getline(cells, cell, ',')) numbers.push_back(std::stod(cell));
  return numbers;
}

TEST(GnssErrors, CovariancesHoldWithTheirStates) {
  const Interval band = ChiSquareInterval(0.99, 3.0 * kFlights);
  const Nees nees = FlightsNees(true);
  const double n = 3.0 * kFlights;
  EXPECT_TRUE(band.Contains(nees.boresight / n)) << nees.boresight / n;
  EXPECT_TRUE(band.Contains(nees.position / n)) << nees.position / n;
}

TEST(GnssErrors, CovariancesBreakWithoutTheirStates) {
  const Interval band = ChiSquareInterval(0.99, 3.0 * kFlights);
  const Nees nees = FlightsNees(false);
  const double n = 3.0 * kFlights;
  EXPECT_GT(nees.boresight / n, band.high);
  EXPECT_GT(nees.position / n, band.high);
}

TEST(GnssErrors, CovariancesInTurnsHoldWithTheStatesOfErrorsByBank) {
  const Interval band = ChiSquareInterval(0.99, 3.0 * kFlights);
  const double n = 3.0 * kFlights;
  const Nees with = FlightsNees(true, kByBank), without = FlightsNees(false, kByBank);
  EXPECT_TRUE(band.Contains(with.boresight / n)) << with.boresight / n;
  EXPECT_TRUE(band.Contains(with.position / n)) << with.position / n;
  EXPECT_GT(without.position / n, band.high);
}

// The error of level flight is a small part of the error in turns, whatever the states are.
TEST(GnssErrors, EstimatesOfErrorsByBankAreLargeInTurnsOnly) {
  const SimulatedFlight sim = FlyWithGnssErrors(3, kByBank);
  AdjustOptions options;
  options.with_pairs = false;
  const Adjustment adjustment = Adjust(sim.flight, options);
  const FlightNetwork& network = *adjustment.network;
  Marginals marginals(network.net());
  marginals.ComputeSelectedInverse();
  EXPECT_EQ(GnssErrorsJson(adjustment, marginals)["processes"][0]["grows_with"], "bank");
  std::istringstream lines(FormatGnssErrors(network, marginals));
  std::string line;
  std::getline(lines, line);
  std::vector<double> level_m, turning_m;  // height errors and their sigmas
  while (std::getline(lines, line)) {
    const std::vector<double> row = Numbers(line);
    const double roll_rad = RollPitchHeading(sim.truth->Nav(row[0]).q_nb).x();
    if (std::abs(roll_rad) < 1.0 * kRadPerDeg) level_m.push_back(std::hypot(row[3], row[6]));
    if (std::abs(roll_rad) > kTurningRad) turning_m.push_back(std::hypot(row[3], row[6]));
  }
  ASSERT_GT(level_m.size(), 20U);
  ASSERT_GT(turning_m.size(), 20U);
  const double per_deg_m = kByBank[0].sigma_enu_m.z() / 30.0;
  EXPECT_LT(*std::max_element(level_m.begin(), level_m.end()), 4.0 * per_deg_m);
  EXPECT_GT(*std::max_element(turning_m.begin(), turning_m.end()), 10.0 * per_deg_m);
}

/// Returns the entry that the warning proposes, as the list of flight.yaml.
std::vector<GnssProcess> Pasted(const std::string& warning) {
  const std::string key = "gnss.processes: ";
  const std::size_t begin = warning.find(key) + key.size();
  const std::string list = warning.substr(begin, warning.find(';', begin) - begin);
  return ParseFlightConfig("gnss: {processes: " + list + "}\n", "/f").gnss->processes;
}

TEST(GnssErrors, TheWarningHasTheEntryToPaste) {
  SimulatedFlight sim = FlyWithGnssErrors(1);
  sim.flight.config.gnss->processes.clear();
  AdjustOptions options;
  options.with_pairs = false;
  Adjustment adjustment = Adjust(sim.flight, options);
  GnssCorrelation& test = adjustment.gnss_correlation;
  test.p_value = {1.0, 1e-9, 0.5};
  test.process = {{0.01234, 0.0, 0.0567}, 118.0};
  const auto warning = GnssErrorWarning(adjustment);
  ASSERT_TRUE(warning);
  EXPECT_THAT(Words(*warning), HasSubstr("lag-1 correlation"));
  const std::vector<GnssProcess> pasted = Pasted(Words(*warning));
  ASSERT_EQ(pasted.size(), 1U);
  EXPECT_EQ(pasted.front(), (GnssProcess{{0.012, 0.0, 0.057}, 120.0}));
  test.p_value.setConstant(0.01);
  test.p_value_together = 0.01;
  EXPECT_FALSE(GnssErrorWarning(adjustment));
}

TEST(GnssErrors, ReportHasTheProcesses) {
  const SimulatedFlight sim = FlyWithGnssErrors(2);
  AdjustOptions options;
  options.with_pairs = false;
  const Adjustment adjustment = Adjust(sim.flight, options);
  const FlightNetwork& network = *adjustment.network;
  Marginals marginals(network.net());
  marginals.ComputeSelectedInverse();
  const Json json = GnssErrorsJson(adjustment, marginals);
  ASSERT_EQ(json["processes"].size(), kProcesses.size());
  const Json& east_north = json["processes"][0];
  EXPECT_EQ(east_north["tau_s"], 120.0);
  EXPECT_EQ(east_north["states"], network.trajectory().gnss_error()[0].blocks.size());
  const Json &estimate_m = east_north["rms_enu_m"], &sigma_m = east_north["posterior_sigma_enu_m"];
  // The variance of the estimates and the posterior variance add up to the stated variance.
  EXPECT_LT(sigma_m[0], 0.015);
  EXPECT_NEAR(std::hypot(estimate_m[0].get<double>(), sigma_m[0].get<double>()), 0.015, 0.006);
  EXPECT_EQ(estimate_m[2], 0.0);
  std::istringstream lines(FormatGnssErrors(network, marginals));
  std::string line;
  long rows = -1;  // -1 for the header
  while (std::getline(lines, line)) ++rows;
  EXPECT_EQ(rows, static_cast<long>(network.gnss().edges().size()));
}

}  // namespace dn::adjustment_test
