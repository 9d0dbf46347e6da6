#include <dn/error.h>
#include <dn/imu/imu_model.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace dn::imu_test {

using Type = BiasProcess::Type;

// The expected factors are those of the table in docs/reference/conventions.md, to the digits
// given there.
TEST(ImuUnits, ConvertDataSheetUnits) {
  EXPECT_NEAR(RadpsFromDegPerHour(1.0), 4.848137e-6, 1e-12);
  EXPECT_NEAR(RadPerSqrtSFromDegPerSqrtHour(1.0), 2.908882e-4, 1e-10);
  EXPECT_DOUBLE_EQ(Mps2FromMg(1.0), 9.80665e-3);
  EXPECT_DOUBLE_EQ(MpsPerSqrtSFromUgPerSqrtHz(1.0), 9.80665e-6);
  EXPECT_DOUBLE_EQ(MpsPerSqrtSFromMpsPerSqrtHour(60.0), 1.0);
  EXPECT_NEAR(RadpsPerSqrtSFromDegPerHourPerSqrtHour(60.0), 4.848137e-6, 1e-12);
  EXPECT_DOUBLE_EQ(Mps2PerSqrtSFromMgPerSqrtHour(60.0), 9.80665e-3);
  EXPECT_DOUBLE_EQ(DegPerHourFromRadps(RadpsFromDegPerHour(0.3)), 0.3);
  EXPECT_DOUBLE_EQ(MgFromMps2(Mps2FromMg(0.7)), 0.7);
}

TEST(ImuPreset, EveryNameGivesAValidModelWithItsSource) {
  EXPECT_THAT(ImuPresetNames(),
              ::testing::ElementsAre("ln200", "airins", "apx15", "imu57", "isa100c"));
  for (const std::string& name : ImuPresetNames()) {
    SCOPED_TRACE(name);
    const ImuModel model = ImuPreset(name);
    EXPECT_EQ(model.name, name);
    EXPECT_FALSE(model.source.empty());
    EXPECT_TRUE(model.approximate);
    EXPECT_NO_THROW(Validate(model));
  }
}

TEST(ImuPreset, Ln200) {
  const ImuModel model = ImuPreset("ln200");
  EXPECT_DOUBLE_EQ(model.gyro.white, RadPerSqrtSFromDegPerSqrtHour(0.07));
  ASSERT_EQ(model.gyro.processes.size(), 2u);
  EXPECT_EQ(model.gyro.processes[0].type, Type::kRandomConstant);
  EXPECT_DOUBLE_EQ(model.gyro.processes[0].sigma, RadpsFromDegPerHour(1.0));
  EXPECT_EQ(model.gyro.processes[1].type, Type::kGaussMarkov);
  EXPECT_DOUBLE_EQ(model.gyro.processes[1].sigma, RadpsFromDegPerHour(0.35));
  EXPECT_EQ(model.gyro.processes[1].tau_s, 100.0);
  EXPECT_DOUBLE_EQ(model.accel.white, 50e-6 * 9.80665);
  EXPECT_NEAR(model.accel.processes[0].sigma, 300e-6 * 9.80665, 1e-15);
  EXPECT_NEAR(model.accel.processes[1].sigma, 50e-6 * 9.80665, 1e-15);
  EXPECT_EQ(model.accel.processes[1].tau_s, 60.0);
}

TEST(ImuPreset, UnknownNameNamesTheNearest) {
  try {
    ImuPreset("apx-15");
    FAIL();
  } catch (const InvalidConfig& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("'apx15'"));
  }
}

TEST(GaussMarkov, StepsComposeExactly) {
  const GaussMarkovStep a = DiscretiseGaussMarkov(2.0, 300.0, 7.0);
  const GaussMarkovStep b = DiscretiseGaussMarkov(2.0, 300.0, 100.0);
  const GaussMarkovStep both = DiscretiseGaussMarkov(2.0, 300.0, 107.0);
  EXPECT_NEAR(both.phi, a.phi * b.phi, 1e-15);
  EXPECT_NEAR(both.q, b.phi * b.phi * a.q + b.q, 1e-14);
}

TEST(GaussMarkov, VarianceIsStationary) {
  for (const double dt : {1e-3, 1.0, 300.0, 1e5}) {
    const GaussMarkovStep step = DiscretiseGaussMarkov(0.5, 300.0, dt);
    EXPECT_NEAR(step.phi * step.phi * 0.25 + step.q, 0.25, 1e-15);
  }
}

// For tau -> infinity at constant density 2 s^2 / tau, the process is a random walk.
TEST(GaussMarkov, LongCorrelationIsARandomWalk) {
  const double density = 3e-4, tau_s = 1e12, dt_s = 10.0;
  const GaussMarkovStep step = DiscretiseGaussMarkov(std::sqrt(density * tau_s / 2.0), tau_s, dt_s);
  EXPECT_NEAR(step.phi, 1.0, 1e-10);
  EXPECT_NEAR(step.q, density * dt_s,
              1e-9 * density * dt_s);  // relative error dt / tau, without cancellation
}

// 2e5 steps of a tenth of tau correspond to about 1e4 independent samples: 1 % accuracy, three
// sigmas.
TEST(GaussMarkov, SimulatedAutocorrelation) {
  const double sigma = 2.0, tau_s = 10.0;
  const GaussMarkovStep step = DiscretiseGaussMarkov(sigma, tau_s, 1.0);
  std::mt19937 rng(3);
  std::normal_distribution<double> normal;
  constexpr int kSteps = 200000, kLag = 10;
  std::vector<double> x(kSteps);
  x[0] = sigma * normal(rng);
  for (int i = 1; i < kSteps; ++i) x[i] = step.phi * x[i - 1] + std::sqrt(step.q) * normal(rng);
  double variance = 0.0, lagged = 0.0;
  for (int i = 0; i + kLag < kSteps; ++i) {
    variance += x[i] * x[i];
    lagged += x[i] * x[i + kLag];
  }
  EXPECT_NEAR(variance / (kSteps - kLag), sigma * sigma, 0.05 * sigma * sigma);
  EXPECT_NEAR(lagged / variance, std::exp(-1.0), 0.04);
}

TEST(ImuModel, ValidateNamesTheError) {
  const auto message = [](const ImuModel& model) -> std::string {
    try {
      Validate(model);
    } catch (const InvalidConfig& e) {
      return e.what();
    }
    return "valid";
  };
  ImuModel model = ImuPreset("airins");
  EXPECT_EQ(message(model), "valid");
  model.accel.white = 0.0;
  EXPECT_THAT(message(model), ::testing::HasSubstr("imu.accel: white noise"));
  model = ImuPreset("airins");
  model.gyro.processes[1].tau_s = std::numeric_limits<double>::infinity();
  EXPECT_THAT(message(model), ::testing::HasSubstr("imu.gyro: bias process 2: tau_s"));
  model = ImuPreset("airins");
  model.gyro.processes[0].sigma = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(message(model), ::testing::HasSubstr("imu.gyro: bias process 1: sigma"));
  model.gyro.processes.clear();
  EXPECT_EQ(message(model), "valid");  // white noise alone is a valid model
  model.vibration = {{1.0, 2.0, 0.1, 0.0}, {1.0, 1.0, 0.1, 0.1}};
  EXPECT_THAT(message(model), ::testing::HasSubstr("imu.vibration 2: the window"));
  model.vibration[1] = {1.0, 2.0, 0.1, -0.1};
  EXPECT_THAT(message(model), ::testing::HasSubstr("imu.vibration 2: a sigma"));
  model.vibration.pop_back();
  EXPECT_EQ(message(model), "valid");
}

}  // namespace dn::imu_test
