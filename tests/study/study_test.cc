#include <dn/diagnosis/solution.h>
#include <dn/error.h>
#include <dn/sim/simulate.h>
#include <dn/study/study.h>
#include <dn/study/study_output.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "study/small_designs.h"

namespace dn::testing::study_test {

using ::testing::HasSubstr;

StudyOptions WithoutRemedies() {
  StudyOptions options;
  options.remedies = false;
  return options;
}

StudyOptions WithEstimate(const std::string& estimate) {
  StudyOptions options = WithoutRemedies();
  options.design.estimate = estimate;
  return options;
}

template <class Thing>
std::string RankMessage(const Thing& thing, const StudyOptions& options) {
  try {
    Study(thing, options);
  } catch (const RankDeficient& error) {
    return error.what();
  }
  return "no RankDeficient was thrown";
}

const StudyDirection* LedBy(const StudyResult& study, const std::string& unknown) {
  for (const StudyDirection& direction : study.weak) {
    if (direction.leading == unknown) return &direction;
  }
  return nullptr;
}

/// A noisy flight of the crossing design with its adjustment, and the study of its scenario.
struct Adjusted {
  Scenario scenario = TwoStripsWith("plan.lines", kWithCrossStrip);
  SimulatedFlight simulated = Simulate(scenario, {.seed = 1});
  Solution solution{simulated.flight};
  StudyResult study = Study(scenario, WithoutRemedies());
};

const Adjusted& AdjustedFlight() {
  static const Adjusted adjusted;
  return adjusted;
}

// The states of the adjustment and the laser vectors of the pairs contain noise.
constexpr double kSameSigma = 0.01;

TEST(Study, SigmasAreThoseOfTheAdjustedFlight) {
  const Adjusted& adjusted = AdjustedFlight();
  const Eigen::Vector3d sigma = adjusted.solution.PredictedBoresight().sigma_rad();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(adjusted.study.boresight.sigma_rad()[i] / sigma[i], 1.0, kSameSigma) << i;
  }
  EXPECT_TRUE(adjusted.study.observable());
  EXPECT_EQ(adjusted.study.source, DesignSource::kScenario);
}

TEST(Study, CorrelationsAreThoseOfTheAdjustedFlight) {
  const Adjusted& adjusted = AdjustedFlight();
  const BoresightResult boresight = adjusted.solution.Boresight();
  constexpr double kSameCorrelation = 0.02;
  const auto expect_same = [&](const BiasCorrelation& a, const BiasCorrelation& b) {
    EXPECT_LT((a.at_barycentre - b.at_barycentre).cwiseAbs().maxCoeff(), kSameCorrelation);
    EXPECT_NEAR(a.max_abs, b.max_abs, kSameCorrelation);
    EXPECT_NEAR(a.rms, b.rms, kSameCorrelation);
  };
  expect_same(adjusted.study.boresight.accel_bias, boresight.accel_bias);
  expect_same(adjusted.study.boresight.gyro_bias, boresight.gyro_bias);
  double largest = 0.0;
  for (const BiasCorrelationAt& at : adjusted.study.correlations) {
    largest = std::max(largest, at.accel.cwiseAbs().maxCoeff());
  }
  EXPECT_DOUBLE_EQ(largest, adjusted.study.boresight.accel_bias.max_abs);
}

TEST(Study, OfTheFlightIsThatOfItsScenario) {
  const Adjusted& adjusted = AdjustedFlight();
  const StudyResult study = Study(adjusted.simulated.flight, WithoutRemedies());
  EXPECT_EQ(study.source, DesignSource::kInsGnss);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(study.boresight.sigma_rad()[i] / adjusted.study.boresight.sigma_rad()[i], 1.0,
                kSameSigma)
        << i;
  }
  EXPECT_TRUE(study.weak.front().tried.empty());
  EXPECT_THAT(RemedyWords(study, study.weak.front()), HasSubstr("not tried"));
}

TEST(Study, APlanWithoutDataIsAFlightOnItsTrajectory) {
  const Adjusted& adjusted = AdjustedFlight();
  Flight plan = adjusted.simulated.flight;
  plan.trajectory = plan.reference;
  plan.imu.reset();
  plan.gnss.reset();
  const StudyResult study = Study(plan, WithoutRemedies());
  EXPECT_EQ(study.source, DesignSource::kTrajectory);
  EXPECT_GT(study.imu_epochs, 10000);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(study.boresight.sigma_rad()[i] / adjusted.study.boresight.sigma_rad()[i], 1.0,
                2.0 * kSameSigma)  // other GNSS epochs, and therefore other nodes
        << i;
  }
}

TEST(Study, MeasuredValuesDoNotEnter) {
  Flight flight = AdjustedFlight().simulated.flight;
  flight.trajectory = flight.reference;
  const StudyResult before = Study(flight, WithoutRemedies());
  for (MapGnssEpoch& epoch : flight.gnss->epochs) epoch.p_m += 5.0 * epoch.R_m_enu.col(2);
  const StudyResult after = Study(flight, WithoutRemedies());
  EXPECT_TRUE(before.boresight.covariance_rad2.isApprox(after.boresight.covariance_rad2, 1e-6));
}

TEST(Study, OneStripIsNamed) {
  const std::string message =
      RankMessage(TwoStripsWith("plan.lines", "[[-600, 0, 600, 0, 200, 45]]"), WithoutRemedies());
  EXPECT_THAT(message, HasSubstr("the boresight is not observable"));
  EXPECT_THAT(message, HasSubstr("at least two strips that overlap"));
}

TEST(Study, NoPairsAreNamed) {
  EXPECT_THAT(RankMessage(TwoStripsWith("pairs.count", "0"), WithoutRemedies()),
              HasSubstr("no pairs of points"));
}

TEST(Study, WithoutGnssThePositionIsNamed) {
  Flight flight = AdjustedFlight().simulated.flight;
  flight.trajectory = flight.reference;
  flight.gnss.reset();
  EXPECT_THAT(RankMessage(flight, WithoutRemedies()), HasSubstr("position"));
}

TEST(Study, ParallelFlatStripsWithEverythingFreeAreNotObservable) {
  Scenario scenario = TwoStripsWith("terrain", "{kind: flat}");
  scenario.plan.turbulence = {};
  const StudyOptions options =
      WithEstimate("gnss_lever_arm, lidar_lever_arm, lidar_time_offset, lidar_range_offset");
  try {
    const StudyResult study = Study(scenario, options);
    EXPECT_FALSE(study.observable());
    EXPECT_FALSE(UnobservableWords(study).empty());
    EXPECT_THAT(StudySummary(study), HasSubstr("NOT OBSERVABLE"));
    EXPECT_EQ(StudyJson(study)["observable"], false);
  } catch (const RankDeficient& error) {
    EXPECT_THAT(error.what(), HasSubstr("free"));
  }
}

TEST(Study, FreeUnknownsHaveTheirSigmas) {
  const StudyResult study =
      Study(TwoStripsWith("plan.lines", kWithCrossStrip),
            WithEstimate("lidar_time_offset, {unknown: gnss_lever_arm, sigma: 0.01}"));
  ASSERT_EQ(study.unknowns.size(), 2u);
  EXPECT_EQ(study.unknowns[0].name, "lidar_time_offset");
  EXPECT_EQ(study.unknowns[0].unit, "s");
  ASSERT_EQ(study.unknowns[0].sigma.size(), 1u);
  EXPECT_GT(study.unknowns[0].sigma[0], 1e-6);
  ASSERT_EQ(study.unknowns[1].sigma.size(), 3u);
  for (const double sigma : study.unknowns[1].sigma) EXPECT_LE(sigma, 0.01);
}

TEST(Study, AnUnknownThatTheModelHasNotIsRefused) {
  EXPECT_THROW(Study(TwoStrips(), WithEstimate("gnss_levr_arm")), InvalidConfig);
}

TEST(Study, ARemedyOfParallelStripsIsOneThatHelps) {
  const StudyResult study = Study(TwoStrips());
  EXPECT_TRUE(study.geometry.parallel);
  EXPECT_FALSE(study.geometry.one_direction);
  ASSERT_FALSE(study.weak.empty());
  const StudyDirection& direction = study.weak.front();
  const auto remedy = direction.remedy();
  ASSERT_TRUE(remedy.has_value());
  EXPECT_LT(remedy->sigma, 0.95 * direction.sigma);
  for (const TriedRemedy& tried : direction.tried) EXPECT_GE(tried.sigma, remedy->sigma);
  const Json json = StudyJson(study)["weak_directions"][0];
  EXPECT_EQ(json["sigma_after_remedy"], remedy->sigma);
  EXPECT_FALSE(json["cause"].get<std::string>().empty());
}

/// Returns the sigma after the remedy of twice the pairs, relative to a study with twice the pairs.
double TriedOverStudied(const Scenario& scenario) {
  const StudyResult study = Study(scenario);
  Scenario changed = scenario;
  changed.pairs.count *= 2;
  const StudyResult with_pairs = Study(changed, WithoutRemedies());
  const StudyDirection& direction = study.weak.front();
  const StudyDirection* same = LedBy(with_pairs, direction.leading);
  if (same == nullptr) return 0.0;
  for (const TriedRemedy& tried : direction.tried) {
    if (tried.kind == RemedyKind::kMorePairs) return tried.sigma / same->sigma;
  }
  ADD_FAILURE() << "more pairs were not tried";
  return 0.0;
}

TEST(Study, ARemedyIsWhatTheChangedScenarioGives) {
  constexpr double kSameNodes = 1e-6;
  // Remedies are compared with nodes at 2 Hz; the study has more.
  constexpr double kFewerNodes = 0.01;
  EXPECT_NEAR(TriedOverStudied(TwoStripsWith("imu.preset", "airins")), 1.0, kSameNodes);
  EXPECT_NEAR(TriedOverStudied(TwoStrips()), 1.0, kFewerNodes);
}

TEST(Study, WeightsOfADirectionAreThoseOfAUnitVector) {
  const StudyResult study = Study(TwoStrips(), WithEstimate("lidar_time_offset, lidar_lever_arm"));
  for (const StudyDirection& direction : study.weak) {
    double sum2 = 0.0;
    for (const auto& [name, weight] : direction.unknowns) sum2 += weight * weight;
    EXPECT_LE(sum2, 1.0 + 1e-9);
    EXPECT_GT(sum2, 0.3);
    EXPECT_GE(direction.correlation, 0.0);
    EXPECT_LE(direction.correlation, 1.0);
  }
}

TEST(Study, TheSummaryFitsOneScreen) {
  const std::string summary = StudySummary(Study(TwoStrips(), WithoutRemedies()));
  EXPECT_LE(std::count(summary.begin(), summary.end(), '\n'), 40);
  EXPECT_THAT(summary, HasSubstr("condition number"));
}

}  // namespace dn::testing::study_test
