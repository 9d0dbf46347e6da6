#include "echoes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace dn::sim_test {

constexpr double kResolution_m = 2.5;

Echoes MakeEchoes(const std::vector<Echo>& list) {
  Echoes echoes;
  for (const Echo& echo : list) echoes.Add(echo);
  return echoes;
}

TEST(Echoes, ThoseWithinAPulseAreOneReturnAtTheirMean) {
  const Echoes one =
      Detected(MakeEchoes({{100.4, 0.1, Surface::kGround}, {100.0, 0.3, Surface::kHighPlant}}),
               kResolution_m, 5);
  ASSERT_EQ(one.count, 1u);
  EXPECT_NEAR(one.list[0].range_m, 100.1, 1e-9);
  EXPECT_NEAR(one.list[0].energy, 0.4, 1e-12);
  EXPECT_EQ(one.list[0].surface, Surface::kHighPlant);
}

TEST(Echoes, ThoseBehindAReturnAreLostUpToTheResolution) {
  const std::vector<Echo> list{{100.0, 0.1, Surface::kHighPlant},
                               {102.0, 0.1, Surface::kLowPlant},
                               {103.0, 0.1, Surface::kGround}};
  const Echoes two = Detected(MakeEchoes(list), kResolution_m, 5);
  ASSERT_EQ(two.count, 2u);
  EXPECT_EQ(two.list[0].surface, Surface::kHighPlant);
  EXPECT_EQ(two.list[1].surface, Surface::kGround);
  EXPECT_EQ(Detected(MakeEchoes(list), 1.0, 5).count, 3u);
  EXPECT_EQ(Detected(MakeEchoes(list), 1.0, 2).count, 2u);
}

TEST(Echoes, AWeakOneIsNotDetectedAndHidesNothing) {
  const Echoes echoes =
      Detected(MakeEchoes({{100.0, 1e-4, Surface::kHighPlant}, {101.0, 0.1, Surface::kGround}}),
               kResolution_m, 5);
  ASSERT_EQ(echoes.count, 1u);
  EXPECT_EQ(echoes.list[0].surface, Surface::kGround);
}

TEST(Echoes, WaterReflectsOnlyBelowTheScanner) {
  const auto energy = [](double angle) {
    return EchoEnergy({100.0, Surface::kWater, std::cos(angle)}, 1.0);
  };
  EXPECT_GT(energy(0.0), EchoEnergy({100.0, Surface::kGround, 1.0}, 1.0));
  EXPECT_EQ(Detected(MakeEchoes({{100.0, energy(0.3), Surface::kWater}}), 2.5, 5).count, 0u);
}

}  // namespace dn::sim_test
