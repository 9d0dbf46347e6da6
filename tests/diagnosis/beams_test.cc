#include <dn/adjustment/beams.h>
#include <dn/diagnosis/beams_output.h>
#include <dn/diagnosis/solution.h>
#include <dn/distributions.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "testing/short_flights.h"

namespace dn::diagnosis_test {

using testing::DroneScenario;
using testing::Fly;
using ::testing::HasSubstr;
using Kind = BeamUnknown::Kind;

/// Returns `count` angles between `first_deg` and `last_deg`, rad.
std::vector<double> EvenAngles(int count, double first_deg, double last_deg) {
  std::vector<double> angles_rad;
  for (int k = 0; k < count; ++k) {
    angles_rad.push_back(kRadPerDeg * (first_deg + (last_deg - first_deg) * k / (count - 1)));
  }
  return angles_rad;
}

/// Returns a drone with a rotating scanner: the angles of a Velodyne VLP-16 or HDL-32E.
Scenario RotatingDrone(int beams, long pairs, double sigma_p_m) {
  Scenario scenario = DroneScenario();
  scenario.lidar.pattern = ScanPattern::kRotating;
  scenario.lidar.beams.angles_rad =
      beams == 16 ? EvenAngles(16, -15.0, 15.0) : EvenAngles(beams, -30.67, 10.67);
  scenario.lidar.beams.angle_sigma_rad = kRadPerDeg * 0.1;
  scenario.lidar.beams.range_sigma_m = 0.03;
  scenario.pairs.count = pairs;
  scenario.pairs.sigma_p_m = sigma_p_m;
  return scenario;
}

/// Returns the true corrections relative to the mean of the beams that measured pairs.
std::vector<double> TrueCorrections(const SimulatedFlight& sim, const BeamCorrections& beams) {
  const BeamScenario& truth = sim.scenario.lidar.beams;
  std::vector<double> values =
      beams.unknown.kind == Kind::kAngle ? truth.angle_error_rad : truth.range_error_m;
  double mean = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (beams.unknown.ends[k] > 0) {
      mean += values[k] / static_cast<double>(beams.unknown.NumMeasured());
    }
  }
  for (double& value : values) value = beams.per_si * (value - mean);
  return values;
}

/// Returns the squared error of the corrections in the metric of their covariance. Their mean is
/// known, so that the expected value is the number of beams minus one.
double Nees(const Solution& solution, const SimulatedFlight& sim, const BeamCorrections& beams) {
  const BlockId id = solution.network().net().Find(beams.unknown.name);
  const Eigen::MatrixXd C = solution.marginals().Covariance(id) * beams.per_si * beams.per_si;
  const std::vector<double> truth = TrueCorrections(sim, beams);
  Eigen::VectorXd error(static_cast<Eigen::Index>(truth.size()));
  for (std::size_t k = 0; k < truth.size(); ++k) {
    error[static_cast<Eigen::Index>(k)] = beams.value[k] - truth[k];
  }
  return error.dot(C.llt().solve(error));
}

SimulatedFlight FlyPure(const Scenario& scenario, std::uint64_t seed) {
  SimulatedFlight sim = Fly(scenario, seed);
  sim.flight.config.unmodelled.none = true;
  return sim;
}

class BeamSizesManyRuns : public ::testing::TestWithParam<int> {};

TEST_P(BeamSizesManyRuns, AreRecoveredToTwoMillimetresAndAHundredthOfADegree) {
  const SimulatedFlight sim = FlyPure(RotatingDrone(GetParam(), 2000, 0.007), 7);
  const Solution solution(sim.flight);
  const std::vector<BeamCorrections> all =
      ExtractBeams(solution.adjustment(), solution.marginals());
  ASSERT_EQ(all.size(), 2u);
  for (const BeamCorrections& beams : all) {
    EXPECT_TRUE(beams.NotObservable().empty());
    const double most = beams.unknown.kind == Kind::kAngle ? 0.01 : 0.002;
    const std::vector<double> truth = TrueCorrections(sim, beams);
    for (std::size_t k = 0; k < truth.size(); ++k) {
      EXPECT_NEAR(beams.value[k], truth[k], most) << beams.unknown.name << " " << k;
      EXPECT_NEAR(beams.value[k], truth[k], 4.5 * beams.sigma[k]);
    }
    const double dof = static_cast<double>(truth.size()) - 1.0;
    EXPECT_GT(ChiSquareTail(Nees(solution, sim, beams), dof), 1e-4) << beams.unknown.name;
  }
}

INSTANTIATE_TEST_SUITE_P(OfScanners, BeamSizesManyRuns, ::testing::Values(16, 32));

TEST(BeamCorrections, ThatThePairsDoNotShowAreRefused) {
  Scenario scenario = RotatingDrone(16, 300, 0.03);
  scenario.lidar.beams.angle_sigma_rad = kRadPerDeg * 1e-4;  // better than pairs can tell
  SimulatedFlight sim = FlyPure(scenario, 2);
  std::erase_if(sim.flight.pairs->pairs,
                [](const LidarPair& pair) { return pair.beam_i == 3 || pair.beam_j == 3; });
  const Solution solution(sim.flight);
  const std::vector<BeamCorrections> all =
      ExtractBeams(solution.adjustment(), solution.marginals());
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].NotObservable().size(), 16u);
  EXPECT_EQ(all[1].NotObservable(), std::vector<std::size_t>{3});
  EXPECT_NEAR(all[1].sigma[3], 0.03, 1e-9);
  EXPECT_NEAR(all[0].sigma[5], all[0].prior_sigma[5], 0.1 * all[0].prior_sigma[5]);
  const std::string text = BeamsSummary(all, true);
  EXPECT_THAT(text, HasSubstr("not observable: beam 3: no point of it was used"));
  EXPECT_THAT(text, HasSubstr("not observable: beams 0 to 2 and 4 to 15: the data say less"));
  Json json;
  AddBeamsJson(all, true, &json);
  EXPECT_EQ(json["beams"][0]["ends"][3], 0);
  EXPECT_TRUE(json["beams"][0]["angle"]["value"][5].is_null());
  EXPECT_TRUE(json["beams"][0]["range_offset"]["value"][5].is_number());
  EXPECT_EQ(json["beams"][0]["range_offset"]["observable"][3], false);
}

// A flight whose pairs have beams is the same one without the key.
TEST(BeamCorrections, BelongToAScannerThatDeclaresThem) {
  SimulatedFlight sim = FlyPure(RotatingDrone(16, 100, 0.03), 2);
  sim.flight.config.lidar->beams.reset();
  const Solution solution(sim.flight);
  EXPECT_TRUE(ExtractBeams(solution.adjustment(), solution.marginals()).empty());
  Json json = Json::object();
  AddBeamsJson({}, true, &json);
  EXPECT_TRUE(json.empty());
  EXPECT_EQ(BeamsSummary({}, true), "");
}

// The effects that the model leaves out make the sigmas of the corrections larger, not smaller.
TEST(BeamCorrections, ContainTheEffectsThatTheModelLeavesOut) {
  const SimulatedFlight sim = Fly(RotatingDrone(16, 1000, 0.02), 4);
  const Solution solution(sim.flight);
  const std::vector<BeamCorrections> pure =
      ExtractBeams(solution.adjustment(), solution.marginals());
  const std::vector<BeamCorrections> checked = solution.CheckedBeams();
  const std::vector<BeamCorrections> predicted = solution.PredictedBeams();
  bool larger = false;
  for (std::size_t k = 0; k < 16; ++k) {
    EXPECT_NEAR(predicted[0].sigma[k], checked[0].sigma[k], 0.05 * checked[0].sigma[k]);
    EXPECT_GE(checked[0].sigma[k], pure[0].sigma[k]);
    larger = larger || checked[0].sigma[k] > 1.0001 * pure[0].sigma[k];
    EXPECT_NEAR(checked[0].value[k], TrueCorrections(sim, checked[0])[k],
                4.5 * checked[0].sigma[k]);
  }
  EXPECT_TRUE(larger);
}

// The squared errors of many flights have the size that the covariances say.
TEST(BeamsSlowRuns, CorrectionsAreWithinTheirSigmas) {
  constexpr int kFlights = 20;
  double sum[2] = {0.0, 0.0}, boresight = 0.0;
  for (int seed = 1; seed <= kFlights; ++seed) {
    const SimulatedFlight sim =
        FlyPure(RotatingDrone(16, 600, 0.03), static_cast<std::uint64_t>(seed));
    const Solution solution(sim.flight);
    const std::vector<BeamCorrections> all =
        ExtractBeams(solution.adjustment(), solution.marginals());
    for (int k = 0; k < 2; ++k) {
      sum[k] += Nees(solution, sim, all[static_cast<std::size_t>(k)]);
    }
    const BoresightResult result = solution.Boresight();
    const Eigen::Vector3d error =
        Log(Eigen::Quaterniond(Exp(result.angles_rad) * Exp(sim.boresight_rad).conjugate()));
    boresight += error.dot(result.covariance_rad2.llt().solve(error));
  }
  RecordProperty("angles", std::to_string(sum[0] / (15.0 * kFlights)));
  RecordProperty("ranges", std::to_string(sum[1] / (15.0 * kFlights)));
  RecordProperty("boresight", std::to_string(boresight / (3.0 * kFlights)));
  for (const double total : sum) {
    EXPECT_GT(ChiSquareTail(total, 15.0 * kFlights), 1e-3) << total;
    EXPECT_LT(ChiSquareTail(total, 15.0 * kFlights), 1.0 - 1e-3) << total;
  }
  EXPECT_GT(ChiSquareTail(boresight, 3.0 * kFlights), 1e-3) << boresight;
  EXPECT_LT(ChiSquareTail(boresight, 3.0 * kFlights), 1.0 - 1e-3) << boresight;
}

}  // namespace dn::diagnosis_test
