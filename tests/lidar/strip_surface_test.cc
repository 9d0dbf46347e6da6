#include <dn/error.h>
#include <dn/lidar/strip_surface.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace dn::lidar_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Heights of a test surface.
using Shape = double (*)(double east_m, double north_m);

double Meadow(double east_m, double north_m) { return 400.0 + 0.1 * east_m - 0.05 * north_m; }
double Slope(double east_m, double) { return 400.0 + 0.2 * east_m; }  // 11 deg
double Steps(double east_m, double north_m) {
  return 400.0 + 3.0 * std::fmod(std::floor(2.5 * east_m) + std::floor(2.5 * north_m), 2.0);
}

FlatSurface Survey(Shape shape, double offset_m, unsigned seed, double width_m = 20.0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(0.0, width_m);
  std::normal_distribution<double> noise(0.0, 0.02);
  StripSurface strip(2.0);
  for (int k = 0; k < 8000; ++k) {
    const double east_m = place(random) - 10.0, north_m = place(random) - 10.0;
    strip.Add({east_m, north_m, shape(east_m, north_m) + offset_m + noise(random)});
  }
  return strip.Flat();
}

TEST(StripSurface, HeightsAreThoseOfTheCentres) {
  const FlatSurface flat = Survey(Meadow, 0.0, 1);
  EXPECT_EQ(flat.up_m.size(), 100u);
  for (const auto& [key, up_m] : flat.up_m) {
    const Vector2d centre_m = CellCentre(key, flat.cell_m);
    EXPECT_NEAR(up_m, Meadow(centre_m.x(), centre_m.y()), 5.0 * 0.02 / std::sqrt(80.0));
    EXPECT_EQ(flat.At(centre_m), up_m);
  }
  EXPECT_FALSE(flat.At({15.0, 0.0}));
}

TEST(StripSurface, PlacesBeyondTheNumbersOfCellsAreInTheLastOne) {
  EXPECT_EQ(CellNumber(-0.1, 2.0), -1);
  EXPECT_EQ(CellNumber(5.9, 2.0), 2);
  EXPECT_EQ(CellNumber(1e12, 2.0), std::numeric_limits<std::int32_t>::max());
  EXPECT_EQ(CellNumber(-1e12, 2.0), std::numeric_limits<std::int32_t>::min());
}

TEST(StripSurface, SlopesAndRoughGroundAreLeftOut) {
  EXPECT_TRUE(Survey(Slope, 0.0, 1).up_m.empty());
  EXPECT_TRUE(Survey(Steps, 0.0, 1).up_m.empty());
}

// On a line, the tilt across it is unknown, and so is the height at the centre.
TEST(StripSurface, PointsOnALineAreLeftOut) {
  StripSurface strip(2.0);
  for (int k = 0; k < 100; ++k) strip.Add({0.02 * k, 0.3, 400.0});
  EXPECT_TRUE(strip.Flat().up_m.empty());
}

TEST(StripSurface, DifferencesAreThoseOfTheStrips) {
  const FlatSurface first = Survey(Meadow, 0.0, 1), second = Survey(Meadow, 0.07, 2, 10.0);
  const auto differences = SurfaceDifferences(first, second);
  EXPECT_EQ(differences.size(), 25u);
  for (const SurfaceDifference& one : differences) EXPECT_NEAR(one.up_m, 0.07, 0.015);
  EXPECT_THROW(SurfaceDifferences(first, FlatSurface{}), InvalidConfig);
}

TEST(StripSurface, KeysOfCellsInAllQuadrants) {
  for (const Vector2d& en_m : {Vector2d(-0.1, 0.1), Vector2d(5e5, -7.3), Vector2d(-2e6, -2e6)}) {
    const Vector2d centre_m = CellCentre(CellKey(en_m, 0.5), 0.5);
    EXPECT_LE((centre_m - en_m).cwiseAbs().maxCoeff(), 0.25 + 1e-9);
  }
}

}  // namespace dn::lidar_test
