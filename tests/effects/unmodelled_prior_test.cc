#include <dn/effects/unmodelled_prior.h>
#include <dn/error.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace dn::effects_test {

constexpr double kRadPerSqrtS = std::numbers::pi / 180.0 / 60.0;  // of 1 deg/sqrt(h)

TEST(UnmodelledPrior, EveryFixedEffectOfAWholeFlightHasAPriorInEveryClass) {
  for (const SensorClass of :
       {SensorClass::kNavigation, SensorClass::kTactical, SensorClass::kMems}) {
    const UnmodelledPrior prior(of);
    EXPECT_FALSE(prior.pure());
    for (const EffectSpec& effect : EffectTable()) {
      const bool expected = effect.fixed() && effect.timing == EffectTiming::kFlight;
      EXPECT_EQ(prior.Sigma(effect.id).sum() > 0.0, expected) << effect.name;
    }
  }
}

TEST(UnmodelledPrior, BetterClassesHaveSmallerOrEqualSizes) {
  const UnmodelledPrior navigation(SensorClass::kNavigation), tactical(SensorClass::kTactical),
      mems(SensorClass::kMems);
  for (const EffectSpec& effect : EffectTable()) {
    if (!effect.fixed()) continue;
    EXPECT_LE(navigation.Sigma(effect.id).sum(), tactical.Sigma(effect.id).sum()) << effect.name;
    EXPECT_LE(tactical.Sigma(effect.id).sum(), mems.Sigma(effect.id).sum()) << effect.name;
  }
}

TEST(UnmodelledPrior, SizesAreInSi) {
  const UnmodelledPrior prior(SensorClass::kNavigation);
  EXPECT_DOUBLE_EQ(prior.Sigma(EffectId::kGyroMisalignment)[2], 0.03e-3);
  EXPECT_DOUBLE_EQ(prior.Sigma(EffectId::kLidarRangeScale)[0], 30e-6);
}

TEST(UnmodelledPrior, ClassesFollowTheWhiteNoise) {
  EXPECT_EQ(ClassByDataSheet(0.002 * kRadPerSqrtS), SensorClass::kNavigation);
  EXPECT_EQ(ClassByDataSheet(0.07 * kRadPerSqrtS), SensorClass::kTactical);
  EXPECT_EQ(ClassByDataSheet(0.2 * kRadPerSqrtS), SensorClass::kMems);
  // A platform shakes: the same unit is noisier in flight.
  EXPECT_EQ(ClassInFlight(0.015 * kRadPerSqrtS), SensorClass::kNavigation);
  EXPECT_EQ(ClassInFlight(0.1 * kRadPerSqrtS), SensorClass::kTactical);
  EXPECT_EQ(ClassInFlight(0.2 * kRadPerSqrtS), SensorClass::kMems);
}

TEST(UnmodelledPrior, StatedSizesReplaceThoseOfTheClass) {
  UnmodelledPrior prior(SensorClass::kMems);
  prior.Set(EffectId::kLidarScanCone, Eigen::VectorXd::Zero(1));
  EXPECT_TRUE(prior.Sigma(EffectId::kLidarScanCone).isZero(0.0));
  EXPECT_TRUE(UnmodelledPrior().pure());
  UnmodelledPrior ruled_out;
  ruled_out.Set(EffectId::kLidarScanCone, Eigen::VectorXd::Zero(1));
  EXPECT_TRUE(ruled_out.pure());
}

TEST(UnmodelledPrior, RefusesWhatIsNoFixedSize) {
  UnmodelledPrior prior;
  EXPECT_THROW(prior.Set(EffectId::kGnssNoiseScale, Eigen::VectorXd::Ones(1)), InvalidInput);
  EXPECT_THROW(prior.Set(EffectId::kGnssLeverArm, Eigen::VectorXd::Ones(2)), InvalidInput);
  EXPECT_THROW(prior.Set(EffectId::kLidarScanCone, -Eigen::VectorXd::Ones(1)), InvalidInput);
  EXPECT_THROW(prior.Set(EffectId::kLidarScanCone,
                         Eigen::VectorXd::Constant(1, std::numeric_limits<double>::infinity())),
               InvalidInput);
}

}  // namespace dn::effects_test
