#include <dn/adjustment/words.h>
#include <dn/diagnosis/reject_control.h>
#include <dn/diagnosis/solution.h>
#include <dn/distributions.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "testing/short_flights.h"

namespace dn::diagnosis_test {

using testing::DroneScenario;
using testing::Fly;
using ::testing::HasSubstr;
using Role = ControlPointCheck::Role;

constexpr const char* kTenPoints = "control: {points: 10, checks: 20, sigma_m: [.01, .01, .015]}\n";

SimulatedFlight FlyWithControl(std::uint64_t seed, bool pure) {
  SimulatedFlight sim = Fly(DroneScenario(kTenPoints), seed);
  sim.flight.config.unmodelled.none = pure;
  return sim;
}

const ControlPointCheck& Find(const ControlCheck& control, const std::string& name) {
  return *std::find_if(control.points.begin(), control.points.end(),
                       [&](const ControlPointCheck& point) { return point.name == name; });
}

/// Returns the root mean square error of the height of the nodes on the strips, m.
double HeightError(const SimulatedFlight& sim, const Solution& solution) {
  double sum = 0.0, nodes = 0.0;
  for (const MapPose& pose : solution.CheckedPoses()) {
    for (const StripInterval& strip : sim.strips) {
      if (pose.t_s < strip.t0_s || pose.t_s > strip.t1_s) continue;
      sum += std::pow(pose.p_mb.z() - sim.truth->Pose(pose.t_s).p_mb.z(), 2);
      ++nodes;
    }
  }
  return std::sqrt(sum / nodes);
}

/// Returns the largest sigma of the height of the nodes on the strips, m.
double HeightSigma(const SimulatedFlight& sim, const Solution& solution) {
  double largest_m = 0.0;
  for (const TrajectorySigma& sigma : solution.CheckedSigmas()) {
    for (const StripInterval& strip : sim.strips) {
      if (sigma.t_s < strip.t0_s || sigma.t_s > strip.t1_s) continue;
      largest_m = std::max(largest_m, sigma.position_enu_m.z());
    }
  }
  return largest_m;
}

// The GNSS positions have a common error of about 8 cm. Ten points with a noise of 2.6 cm each
// bring the height to 1 cm.
TEST(ControlCheckManyRuns, TenPointsBringTheHeightToTheirSigma) {
  Scenario scenario = DroneScenario(kTenPoints);
  scenario.gnss.processes.push_back({Eigen::Vector3d(0.05, 0.05, 0.08), 3000.0});
  double worst_with_m = 0.0, worst_without_m = 0.0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SimulatedFlight sim = Fly(scenario, seed);
    sim.flight.config.unmodelled.none = true;
    const Solution with(sim.flight);
    SimulatedFlight bare = sim;
    bare.flight.control.reset();
    const Solution without(bare.flight);
    EXPECT_GT(HeightSigma(sim, without), 0.05);
    EXPECT_LT(HeightSigma(sim, with), 0.018);
    EXPECT_LT(HeightError(sim, with), 4.0 * HeightSigma(sim, with));
    worst_with_m = std::max(worst_with_m, HeightError(sim, with));
    worst_without_m = std::max(worst_without_m, HeightError(sim, without));
    EXPECT_FALSE(without.model_check().control);
    ASSERT_TRUE(with.model_check().control);
    EXPECT_EQ(with.model_check().control->points.size(), 30u);
  }
  EXPECT_GT(worst_without_m, worst_with_m);
}

TEST(ControlCheck, ChecksGiveTheAccuracyOfTheProduct) {
  const SimulatedFlight sim = FlyWithControl(3, true);
  const Solution solution(sim.flight);
  const ControlCheck& control = *solution.model_check().control;
  ASSERT_TRUE(control.vertical && control.horizontal && control.variance_of_checks);
  EXPECT_EQ(control.vertical->checks, 20);
  EXPECT_NEAR(control.vertical->survey_m, 0.015, 1e-9);
  EXPECT_NEAR(control.horizontal->survey_m, 0.01 * std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(control.vertical->combined_m(),
              std::hypot(control.vertical->rmse_m, control.vertical->survey_m), 1e-12);
  EXPECT_LT(control.vertical->rmse_m, 0.06);
  EXPECT_EQ(control.check_components, 60);
}

// The influence of an observation is the change of the boresight if it is left out.
TEST(ControlCheck, TheInfluenceOfAPointIsTheChangeWithoutIt) {
  SimulatedFlight sim = FlyWithControl(5, true);
  const Solution with(sim.flight);
  const ControlPointCheck& point = Find(*with.model_check().control, "P3");
  for (ControlPoint& one : sim.flight.control->points) {
    if (one.name == "P3") one.is_check = true;
  }
  const Solution without(sim.flight);
  const Eigen::Vector3d change = Log(Eigen::Quaterniond(
      Exp(without.Boresight().angles_rad) * Exp(with.Boresight().angles_rad).conjugate()));
  const double scale = with.Boresight().sigma_rad().maxCoeff();
  EXPECT_NEAR((change - point.boresight_rad).norm() / scale, 0.0, 1e-3);
  const ControlPointCheck& check = Find(*without.model_check().control, "P3");
  EXPECT_NEAR((check.residual_m - point.residual_m).norm(), 0.0, 1e-4);
  EXPECT_NEAR(check.statistic, point.statistic, 1e-2 * point.statistic);
}

TEST(ControlCheck, AWrongPointIsNamedAndLeftOut) {
  for (const bool pure : {true, false}) {
    SimulatedFlight sim = FlyWithControl(6, pure);
    const Solution right(sim.flight);
    for (ControlPoint& point : sim.flight.control->points) {
      if (point.name == "P7") point.p_m.y() += 0.5;
    }
    std::optional<Solution> solution(std::in_place, sim.flight);
    RejectWrongControl(sim.flight, {}, &solution);
    const ModelCheck& check = solution->model_check();
    EXPECT_EQ(Find(*check.control, "P7").role, Role::kRejected);
    EXPECT_EQ(solution->adjustment().control_rejected.size(), 1u);
    EXPECT_THAT(Find(*check.control, "P7").residual_m.y(), ::testing::DoubleNear(-0.5, 0.15));
    std::string words;
    for (const std::string& text : Words(check.findings)) words += text + "\n";
    EXPECT_THAT(words, HasSubstr("control point P7 contradicts all other data"));
    const Eigen::Vector3d moved =
        solution->CheckedBoresight().angles_rad - right.CheckedBoresight().angles_rad;
    EXPECT_LT(moved.cwiseQuotient(right.CheckedBoresight().sigma_rad()).cwiseAbs().maxCoeff(), 1.0);
  }
}

TEST(ControlCheck, AnotherDatumIsNamedOrEstimated) {
  SimulatedFlight sim = FlyWithControl(8, true);
  const Eigen::Vector3d shift_m(0.4, -0.3, 1.5);
  for (ControlPoint& point : sim.flight.control->points) point.p_m += shift_m;
  const Solution named(sim.flight);
  ASSERT_TRUE(named.model_check().control->shift);
  EXPECT_LT(named.model_check().control->shift->p_value, 1e-3);
  EXPECT_NEAR((named.model_check().control->shift->shift_m - shift_m).norm(), 0.0, 0.1);
  EXPECT_TRUE(named.model_check().contradicted());

  sim.flight.config.control.emplace().datum_shift_sigma_m = Eigen::Vector3d::Constant(2.0);
  const Solution estimated(sim.flight);
  const ControlShift& shift = *estimated.model_check().control->shift;
  EXPECT_TRUE(shift.estimated);
  EXPECT_LT((shift.shift_m - shift_m).cwiseQuotient(shift.sigma_m).cwiseAbs().maxCoeff(), 4.0);
  EXPECT_LT(shift.sigma_m.maxCoeff(), 0.1);
  EXPECT_FALSE(estimated.model_check().contradicted());
}

/// Checks the statistics of 20 flights.
void ExpectConsistentChecks(bool pure) {
  constexpr int kFlights = 20;
  double checks = 0.0, components = 0.0, nees = 0.0;
  int named = 0;
  for (std::uint64_t seed = 1; seed <= kFlights; ++seed) {
    SimulatedFlight sim = FlyWithControl(seed, pure);
    const Solution solution(sim.flight);
    const ControlCheck& control = *solution.model_check().control;
    checks += *control.variance_of_checks * control.check_components;
    components += control.check_components;
    const BoresightResult boresight = solution.CheckedBoresight();
    const Eigen::Vector3d error =
        Log(Eigen::Quaterniond(Exp(boresight.angles_rad) * Exp(sim.boresight_rad).conjugate()));
    nees += error.dot(boresight.covariance_rad2.llt().solve(error));
    ControlPoint& wrong = sim.flight.control->points[seed % 10];
    wrong.p_m[static_cast<Eigen::Index>(seed % 3)] += 0.5;
    std::optional<Solution> wronged(std::in_place, sim.flight);
    RejectWrongControl(sim.flight, {}, &wronged);
    if (Find(*wronged->model_check().control, wrong.name).role == Role::kRejected) ++named;
  }
  // Checks of one flight share errors of its trajectory: the interval of half their number.
  EXPECT_TRUE(ChiSquareInterval(0.999, 0.5 * components).Contains(checks / components))
      << checks / components;
  EXPECT_TRUE(ChiSquareInterval(0.999, 3.0 * kFlights).Contains(nees / (3.0 * kFlights)))
      << nees / (3.0 * kFlights);
  EXPECT_GE(named, kFlights - 1);
}

TEST(ControlCheckSlowRuns, ChecksHaveTheirPredictedVarianceInThePureModel) {
  ExpectConsistentChecks(true);
}

}  // namespace dn::diagnosis_test
