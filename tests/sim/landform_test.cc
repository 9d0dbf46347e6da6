#include "landform.h"

#include <dn/sim/random.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dn::sim_test {

using Eigen::Vector2d;

void ExpectWithinBounds(const Landform& form) {
  constexpr double kStep_m = 0.01, kTileRadius_m = 3.0;
  Random random(1, "places");
  const Landform::Bounds all = form.Everywhere();
  double highest_m = 0.0, steepest = 0.0;
  for (int i = 0; i < 100000; ++i) {
    const double east_m = random.Uniform(-900.0, 900.0), north_m = random.Uniform(-900.0, 900.0);
    const double azimuth = random.Uniform(0.0, 6.28), apart_m = random.Uniform(0.0, kTileRadius_m);
    const Vector2d tile(east_m, north_m), heading(std::cos(azimuth), std::sin(azimuth));
    const Vector2d at = tile + (apart_m - kStep_m) * heading;
    const Landform::Bounds near = form.Near(tile, kTileRadius_m);
    const double height_m = form.At(at);
    const double slope = std::abs(form.At(at + kStep_m * heading) - height_m) / kStep_m;
    ASSERT_LE(height_m, near.highest_m + 1e-12);
    ASSERT_LE(near.highest_m, all.highest_m);
    ASSERT_GE(height_m, all.lowest_m);
    ASSERT_LE(slope, near.slope + 1e-6) << at.transpose();
    highest_m = std::max(highest_m, std::abs(height_m));
    steepest = std::max(steepest, slope);
  }
  EXPECT_GT(highest_m, 0.1);
  EXPECT_GT(steepest, 0.3);
}

TEST(Landform, CropRowsStayWithinTheirBounds) { ExpectWithinBounds(*MakeCropRows(3)); }

TEST(Landform, QuarriesStayWithinTheirBounds) { ExpectWithinBounds(*MakeQuarry(3)); }

TEST(Landform, ExistsOnlyInQuarriesAndOnFields) {
  TerrainScenario scenario;
  for (const TerrainKind kind : {TerrainKind::kForest, TerrainKind::kTown, TerrainKind::kMixed}) {
    scenario.kind = kind;
    EXPECT_EQ(MakeLandform(scenario), nullptr);
  }
  scenario.kind = TerrainKind::kQuarry;
  EXPECT_NE(MakeLandform(scenario), nullptr);
}

}  // namespace dn::sim_test
