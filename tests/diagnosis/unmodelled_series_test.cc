#include <dn/adjustment/words.h>
#include <dn/diagnosis/solution.h>
#include <dn/sim/draw_effects.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstddef>

#include "testing/short_flights.h"

namespace dn::diagnosis_test {

/// Sums of normalised squared errors over flights.
struct Series {
  int flights = 0, calibrated = 0;
  double reported = 0.0, modelled = 0.0;  // sums of e^T C^-1 e

  /// Flies with every effect of the class drawn at once, and adjusts.
  void Add(const Scenario& scenario, unsigned seed) {
    const SimulatedFlight sim = testing::Fly(scenario, seed);
    const Solution solution(sim.flight);
    const BoresightResult boresight = solution.CheckedBoresight();
    const auto nees = [&](const Eigen::Vector3d& angles_rad, const Eigen::Matrix3d& covariance) {
      const Eigen::Vector3d error =
          Log(Eigen::Quaterniond(Exp(angles_rad) * Exp(sim.boresight_rad).conjugate()));
      return error.dot(covariance.llt().solve(error));
    };
    ++flights;
    calibrated += boresight.verdict == Verdict::kCalibrated ? 1 : 0;
    EXPECT_NE(boresight.verdict, Verdict::kContradicted)
        << seed << ": " << Words(boresight.reasons.front());
    reported += nees(boresight.angles_rad, boresight.covariance_rad2);
    modelled += nees(boresight.as_modelled->angles_rad, boresight.as_modelled->covariance_rad2);
  }
};

Series FlyMany(Scenario (*make)(const std::string&), SensorClass of, int flights) {
  Series series;
  for (int k = 0; k < flights; ++k) {
    const auto seed = static_cast<unsigned>(100 + k);
    Scenario scenario = make("");
    scenario.effects = DrawEffects(UnmodelledPrior(of), 1.0, seed);
    series.Add(scenario, seed);
  }
  return series;
}

/// Expects the mean of 3 n squares within its 99.9 % band (Wilson and Hilferty), and nearly all
/// flights calibrated. The pure model is far outside.
void ExpectHonest(const Series& series) {
  const double n = 3.0 * series.flights, k = 2.0 / (9.0 * n);
  EXPECT_LT(series.reported / n, std::pow(1.0 - k + 3.29 * std::sqrt(k), 3));
  EXPECT_GT(series.reported / n, std::pow(1.0 - k - 3.29 * std::sqrt(k), 3));
  EXPECT_GT(series.modelled, 1.5 * series.reported);
  EXPECT_GE(series.calibrated, series.flights - 1);
}

TEST(UnmodelledSlowRuns, WithAllEffectsAtOnceOnANavigationGradeAircraft) {
  ExpectHonest(FlyMany(&testing::AircraftScenario, SensorClass::kNavigation, 25));
}

TEST(UnmodelledSlowRuns, WithAllEffectsAtOnceOnADrone) {
  ExpectHonest(FlyMany(&testing::DroneScenario, SensorClass::kMems, 25));
}

}  // namespace dn::diagnosis_test
