#include <dn/sim/draw_effects.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "small_scenario.h"

namespace dn::sim_test {

TEST(DrawSharedPairErrors, DrawsSizesAndLengthsOfThePrior) {
  constexpr int kFlights = 6400;
  std::map<double, int> ratios, lengths_m;
  int without = 0;
  for (int seed = 1; seed <= kFlights; ++seed) {
    PairScenario pairs;
    DrawSharedPairErrors(1.0, static_cast<std::uint64_t>(seed), &pairs);
    if (pairs.shared_fraction == 0.0) {
      ++without;
      continue;
    }
    const double ratio = pairs.shared_fraction / (1.0 - pairs.shared_fraction);
    ++ratios[std::round(std::log2(ratio))];
    ++lengths_m[pairs.shared_length_m];
  }
  const auto expect_count = [](int count, double expected) {
    EXPECT_NEAR(count, expected, 5.0 * std::sqrt(expected));
  };
  expect_count(without, kFlights / 2.0);
  ASSERT_EQ(ratios.size(), 8u);
  for (const auto& [exponent, count] : ratios) expect_count(count, kFlights / 16.0);
  ASSERT_EQ(lengths_m.size(), 4u);
  for (const auto& [length, count] : lengths_m) expect_count(count, kFlights / 8.0);
  EXPECT_EQ(ratios.begin()->first, -7.0);
  EXPECT_EQ(lengths_m.begin()->first, 15.0);
}

TEST(DrawSharedPairErrors, TheFactorScalesTheErrors) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    PairScenario once, twice;
    DrawSharedPairErrors(1.0, seed, &once);
    DrawSharedPairErrors(2.0, seed, &twice);
    const auto ratio = [](const PairScenario& pairs) {
      return pairs.shared_fraction / (1.0 - pairs.shared_fraction);
    };
    EXPECT_NEAR(ratio(twice), 4.0 * ratio(once), 1e-9);
  }
}

TEST(WithDrawnEffects, AWrittenScenarioHasTheSameEffects) {
  const Scenario drawn = WithDrawnEffects(testing::SmallScenario(), 1.0, 7);
  const Scenario read = ParseScenario(FormatScenario(drawn), "drawn.yaml");
  ASSERT_GT(drawn.effects.size(), 10u);
  ASSERT_EQ(read.effects.size(), drawn.effects.size());
  for (std::size_t k = 0; k < read.effects.size(); ++k) {
    EXPECT_EQ(read.effects[k].name, drawn.effects[k].name);
    EXPECT_EQ(read.effects[k].value, drawn.effects[k].value);
  }
}

}  // namespace dn::sim_test
