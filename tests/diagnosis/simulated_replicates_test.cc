#include "simulated_replicates.h"

#include <dn/adjustment/result.h>
#include <dn/diagnosis/replicate_scenario.h>
#include <dn/sim/random.h>
#include <gtest/gtest.h>

#include "network_fit.h"
#include "network_source.h"
#include "testing/short_flights.h"

namespace dn::diagnosis_internal {

using testing::DroneScenario;

constexpr int kSimulatedReplicates = 5;
constexpr int kLinearReplicates = 100;

GapCause RangeOffset(double offset_m) {
  GapCause cause;
  cause.effect = "lidar_range_offset";
  cause.unit = "m";
  cause.estimate = Eigen::VectorXd::Constant(1, offset_m);
  return cause;
}

/// A flight with wrong ranges, its linear replicates, and replicates simulated without and with
/// this effect.
class SimulatedReplicates : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    flight_ = new Flight(
        Simulate(DroneScenario("effects: [{effect: lidar_range_offset, value: 0.15}]"), {}).flight);
    const GapOptions options;
    const NetworkFit fit = NetworkFitter(*flight_, options).Fit({});
    const Comparison compared = CompareNetwork(fit, {.count = kLinearReplicates});
    linear_ = new LinearReplicates(
        NameLinearReplicates(compared.statistics, compared.replicates, compared.test));
    shown_ = new NamedStatistics(Comparable(compared.statistics, compared.appearance.locations));
    without_ = new std::vector<NamedStatistics>(Fly(fit, {}));
    with_ = new std::vector<NamedStatistics>(Fly(fit, {RangeOffset(0.15)}));
  }

  static std::vector<NamedStatistics> Fly(const NetworkFit& fit,
                                          const std::vector<GapCause>& causes) {
    const Trajectory trajectory(DenseTrajectory(fit.solution->network(), 0.01));
    SimulatedReplicateOptions options;
    options.count = kSimulatedReplicates;
    options.threads = 2;
    return SimulateReplicates(
        *flight_,
        MakeReplicateScenario(*flight_, trajectory, causes, fit.solution->Boresight().angles_rad),
        trajectory, options);
  }

  static void TearDownTestSuite() {
    delete flight_;
    delete linear_;
    delete shown_;
    delete without_;
    delete with_;
  }

  static Flight* flight_;
  static LinearReplicates* linear_;
  static NamedStatistics* shown_;
  static std::vector<NamedStatistics>*without_, *with_;
};

Flight* SimulatedReplicates::flight_ = nullptr;
LinearReplicates* SimulatedReplicates::linear_ = nullptr;
NamedStatistics* SimulatedReplicates::shown_ = nullptr;
std::vector<NamedStatistics>* SimulatedReplicates::without_ = nullptr;
std::vector<NamedStatistics>* SimulatedReplicates::with_ = nullptr;

TEST_F(SimulatedReplicates, HaveTheStatisticsOfTheFlight) {
  ASSERT_EQ(without_->size(), static_cast<std::size_t>(kSimulatedReplicates));
  for (const char* name : {"gnss position east, mean square", "lidar p2p up, mean, strips 1-2",
                           "gyro inertial gyro x, mean square"}) {
    EXPECT_TRUE(without_->front().count(name)) << name;
    EXPECT_TRUE(shown_->count(name)) << name;
  }
}

TEST_F(SimulatedReplicates, WithoutEffectsAreThoseOfTheLinearModel) {
  const auto p = TestSimulatedAgainstLinear(*without_, *linear_, 1);
  ASSERT_TRUE(p.has_value());
  EXPECT_GT(*p, 0.005);
}

TEST_F(SimulatedReplicates, WithAnEffectAreOthers) {
  const auto p = TestSimulatedAgainstLinear(*with_, *linear_, 1);
  ASSERT_TRUE(p.has_value());
  EXPECT_LT(*p, 0.005);
}

TEST_F(SimulatedReplicates, WithItsEffectLookLikeTheFlight) {
  const auto right = TestAmongReplicates(*shown_, *with_, *linear_, 1);
  const auto wrong = TestAmongReplicates(*shown_, *without_, *linear_, 1);
  ASSERT_TRUE(right && wrong);
  EXPECT_GT(*right, 0.01);
  EXPECT_LT(*wrong, 0.01);
}

TEST_F(SimulatedReplicates, OfFewThereIsNoTest) {
  const std::vector<NamedStatistics> two(with_->begin(), with_->begin() + 2);
  EXPECT_FALSE(TestSimulatedAgainstLinear(two, *linear_, 1).has_value());
  EXPECT_FALSE(TestAmongReplicates(*shown_, two, *linear_, 1).has_value());
}

/// Returns statistics of noise alone.
NamedStatistics Noise(int count, Random* random) {
  NamedStatistics values;
  for (int k = 0; k < count; ++k) values["statistic " + std::to_string(k)] = random->Normal();
  return values;
}

// The statistics are those in which the flight is most unusual. Without a gap, it is unusual by
// chance only.
TEST(TestAmongReplicates, IsUniformForAFlightThatIsOneMoreReplicate) {
  constexpr int kFlights = 60, kStatistics = 120;
  int below = 0;
  for (int flight = 0; flight < kFlights; ++flight) {
    Random random(static_cast<std::uint64_t>(flight), "flights like their twins");
    LinearReplicates linear;
    for (int k = 0; k < 2 * kLinearReplicates; ++k)
      linear.all.push_back(Noise(kStatistics, &random));
    for (const auto& [name, value] : linear.all.front()) {
      linear.mean[name] = 0.0;
      linear.sigma[name] = 1.0;
    }
    std::vector<NamedStatistics> replicates;
    for (int k = 0; k < 8; ++k) replicates.push_back(Noise(kStatistics, &random));
    const auto p = TestAmongReplicates(Noise(kStatistics, &random), replicates, linear, 1);
    ASSERT_TRUE(p.has_value());
    below += *p < 0.1 ? 1 : 0;
  }
  EXPECT_LE(below, 13);  // 6 +- 2.3 are expected
}

TEST(ReplicateMeanAndSigma, CoversTheReplicatesThatHaveTheStatistic) {
  const std::vector<NamedStatistics> replicates{{{"a", 1.0}}, {{"a", 3.0}, {"b", 5.0}}};
  ASSERT_TRUE(ReplicateMeanAndSigma(replicates, "a").has_value());
  EXPECT_DOUBLE_EQ(ReplicateMeanAndSigma(replicates, "a")->mean, 2.0);
  EXPECT_DOUBLE_EQ(ReplicateMeanAndSigma(replicates, "a")->sigma, std::sqrt(2.0));
  EXPECT_FALSE(ReplicateMeanAndSigma(replicates, "b").has_value());
}

}  // namespace dn::diagnosis_internal
