#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "agree_with_neighbours.h"
#include "fill_voids.h"
#include "height_raster.h"
#include "patches.h"
#include "point_tree.h"
#include "register_patches.h"
#include "testing/rough_town.h"

namespace dn::matching_internal {

using dn::testing::RoughTown;
using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;

constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();
const Vector3d kShift_m(1.3, -0.9, 0.4);

RasterGrid Grid(int cells, double cell_m) {
  RasterGrid grid;
  grid.cell_m = cell_m;
  grid.nx = grid.ny = cells;
  return grid;
}

TEST(FillVoids, AHoleGetsTheMedianAndAShadowTheLowestOfItsNeighbours) {
  std::vector<float> hole{1, 2, 3, 4, kVoid, 6, 7, 8, 9};
  FillVoids(3, 3, 0, &hole);
  EXPECT_EQ(hole[4], 6.0F);

  // The row has a roof of 8 m, its shadow, and the ground.
  const int n = 8;
  std::vector<float> row;
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < n; ++x) row.push_back(x < 3 ? 8.0F : x < 6 ? kVoid : 0.0F);
  }
  FillVoids(n, 3, 6, &row);
  EXPECT_EQ(row[n + 5], 0.0F);
  EXPECT_EQ(row[n + 4], 0.0F);
}

TEST(FillVoids, AVoidLargerThanTheShadowStaysVoid) {
  std::vector<float> z(81, kVoid);
  z[0] = z[1] = z[9] = 1.0F;
  FillVoids(9, 9, 2, &z);
  EXPECT_TRUE(std::isnan(z[80]));
}

TEST(FindShift, IsFoundToAPartOfACellOverHouses) {
  const RoughTown town;
  const RasterGrid grid = Grid(150, 1.0);
  const HeightRaster a = MakeRaster(grid, town.Points(60000, 150.0, 0.02, Vector3d::Zero(), 1), 0);
  const HeightRaster b = MakeRaster(grid, town.Points(60000, 150.0, 0.02, kShift_m, 2), 0);
  const auto shift = FindShift(a, b, {75, 75}, 16, 6);
  ASSERT_TRUE(shift);
  EXPECT_LT((*shift - kShift_m).head<2>().norm(), 0.7);
  EXPECT_NEAR(shift->z(), kShift_m.z(), 0.5);
}

TEST(FindShift, IsNotMadeUpOnFlatGround) {
  const RoughTown flat(true);
  const RasterGrid grid = Grid(80, 1.0);
  const HeightRaster a = MakeRaster(grid, flat.Points(20000, 80.0, 0.02, Vector3d::Zero(), 1), 0);
  const HeightRaster b = MakeRaster(grid, flat.Points(20000, 80.0, 0.02, kShift_m, 2), 0);
  EXPECT_FALSE(FindShift(a, b, {40, 40}, 16, 6));
}

TEST(FindShift, IsNotTakenWhereThePatternRepeats) {
  const auto waves = [](unsigned seed) {
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> noise(0.0, 0.1);
    std::vector<Vector3d> points;
    for (int x = 0; x < 100; ++x) {
      for (int y = 0; y < 100; ++y) {
        points.emplace_back(x + 0.5, y + 0.5,
                            std::sin(1.05 * x) + std::sin(1.05 * y) + noise(engine));
      }
    }
    return MakeRaster(Grid(100, 1.0), points, 0);
  };
  EXPECT_FALSE(FindShift(waves(1), waves(2), {50, 50}, 12, 8));
}

/// Returns the points of a town within a radius of a place.
std::vector<Vector3d> Around(const std::vector<Vector3d>& points_m, const Vector2d& at_en_m,
                             double radius_m) {
  std::vector<Vector3d> kept;
  for (const Vector3d& p_m : points_m) {
    if ((p_m.head<2>() - at_en_m).norm() < radius_m) kept.push_back(p_m);
  }
  return kept;
}

std::optional<Registration> RegisterTown(const RoughTown& town, unsigned seed) {
  const Vector2d centre(62.0, 62.0);
  const double radius_m = 18.0;
  const PatchSurface a(
      Around(town.Points(90000, 150.0, 0.02, Vector3d::Zero(), 2 * seed), centre, radius_m), 1.2);
  const PatchSurface b(Around(town.Points(90000, 150.0, 0.02, kShift_m, 2 * seed + 1),
                              centre + kShift_m.head<2>(), radius_m + 1.5),
                       1.2);
  return RegisterPatches(a, b, kShift_m + Vector3d(0.3, -0.25, 0.1), {centre, radius_m, 1.5});
}

TEST(RegisterPatches, FindTheShiftWithinItsCovariance) {
  const RoughTown town;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const auto registration = RegisterTown(town, seed);
    ASSERT_TRUE(registration);
    const Vector3d error_m = registration->shift_m - kShift_m;
    EXPECT_LT(error_m.norm(), 0.1);
    const Eigen::Matrix3d C = registration->Covariance(registration->variance_ratio);
    EXPECT_LT(error_m.dot(C.inverse() * error_m), 25.0);
    EXPECT_GT(registration->used_share, 0.4);
  }
}

TEST(RegisterPatches, SayWhenADirectionIsFree) {
  const auto flat = RegisterTown(RoughTown(true), 1);
  if (flat) {  // the noise tilts the normals a little, which gives little information
    EXPECT_GT(std::sqrt(flat->Covariance(flat->variance_ratio).trace()), 0.02);
  }
}

TEST(ChoosePatches, AreWhereTheGroundHasShapeAndDoNotOverlap) {
  const RoughTown town;
  const HeightRaster a =
      MakeRaster(Grid(150, 1.0), town.Points(90000, 150.0, 0.02, Vector3d::Zero(), 1), 6);
  const PatchOptions options{{8, 16}, 4.0, 3000.0, 0.3, 3000, 100};
  const std::vector<Patch> patches = ChoosePatches(a, a, options);
  EXPECT_GT(patches.size(), 20u);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    EXPECT_GT(patches[i].information, 0.3);
    for (std::size_t k = 0; k < i; ++k) {
      const int apart = (patches[i].cell - patches[k].cell).cwiseAbs().maxCoeff();
      EXPECT_GT(apart, patches[i].half_cells + patches[k].half_cells);
    }
  }
  const HeightRaster flat =
      MakeRaster(Grid(150, 1.0), RoughTown(true).Points(90000, 150.0, 0.0, Vector3d::Zero(), 1), 6);
  EXPECT_TRUE(ChoosePatches(flat, flat, options).empty());
}

TEST(ChoosePatches, AreSharedOutWhereThereAreTooMany) {
  const RoughTown town;
  const HeightRaster a =
      MakeRaster(Grid(150, 1.0), town.Points(90000, 150.0, 0.02, Vector3d::Zero(), 1), 6);
  const std::vector<Patch> patches = ChoosePatches(a, a, {{8, 16}, 4.0, 3000.0, 0.3, 9, 50});
  ASSERT_EQ(patches.size(), 9u);
  int west = 0, south = 0;
  for (const Patch& patch : patches) {
    west += patch.cell.x() < 75 ? 1 : 0;
    south += patch.cell.y() < 75 ? 1 : 0;
  }
  EXPECT_THAT(west, ::testing::AllOf(::testing::Ge(3), ::testing::Le(7)));
  EXPECT_THAT(south, ::testing::AllOf(::testing::Ge(3), ::testing::Le(7)));
}

/// Returns shifts on a grid with twice their stated sigmas.
std::vector<PlacedShift> ScatteredShifts() {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  std::vector<PlacedShift> shifts;
  for (int i = 0; i < 200; ++i) {
    PlacedShift shift;
    const int row = i / 20;
    shift.at_en_m = Vector2d(10.0 * (i % 20), 10.0 * row);
    shift.shift_m = kShift_m;
    for (int axis = 0; axis < 3; ++axis) shift.shift_m[axis] += 0.1 * normal(engine);
    shift.covariance_m2 = 0.05 * 0.05 * Eigen::Matrix3d::Identity();
    shifts.push_back(shift);
  }
  return shifts;
}

TEST(AgreeWithNeighbours, LeavesOutTheWrongOneAndScalesTheRest) {
  std::vector<PlacedShift> shifts = ScatteredShifts();
  shifts[77].shift_m.y() += 2.0;
  const Agreement agreement = AgreeWithNeighbours(shifts);
  EXPECT_FALSE(agreement.agrees[77]);
  EXPECT_GE(std::count(agreement.agrees.begin(), agreement.agrees.end(), true), 190);
  EXPECT_NEAR(agreement.variance_factor, 4.0, 1.0);
}

TEST(AgreeWithNeighbours, WhatAnErrorOfAttitudeDoesIsNoDisagreement) {
  std::vector<PlacedShift> shifts = ScatteredShifts();
  for (PlacedShift& shift : shifts) {  // differences of half a metre between neighbours
    shift.shift_m.x() += 0.05 * shift.at_en_m.y();
    shift.shift_m.z() -= 0.05 * shift.at_en_m.x();
  }
  const Agreement agreement = AgreeWithNeighbours(shifts);
  EXPECT_GE(std::count(agreement.agrees.begin(), agreement.agrees.end(), true), 190);
  EXPECT_NEAR(agreement.variance_factor, 4.0, 1.0);
}

TEST(PointTree, FindsWhatALookAtEveryPointFinds) {
  std::mt19937_64 engine(7);
  std::uniform_real_distribution<double> uniform(0.0, 10.0);
  const auto random = [&] {
    return Vector3d(5e5 + uniform(engine), 5e6 + uniform(engine), uniform(engine));
  };
  std::vector<Vector3d> points_m(500);
  for (Vector3d& p_m : points_m) p_m = random();
  const PointTree tree(points_m);
  constexpr double kRadius_m = 2.0;
  for (int trial = 0; trial < 200; ++trial) {
    const Vector3d at_m = random();
    std::vector<std::size_t> within;
    double nearest_m = 1e9;
    for (std::size_t k = 0; k < points_m.size(); ++k) {
      const double distance_m = (points_m[k] - at_m).norm();
      nearest_m = std::min(nearest_m, distance_m);
      if (distance_m < kRadius_m) within.push_back(k);
    }
    const PointTree::Nearest nearest = tree.NearestTo(at_m);
    EXPECT_NEAR(nearest.distance_m, nearest_m, 1e-5);
    EXPECT_NEAR((points_m[nearest.index] - at_m).norm(), nearest_m, 1e-5);
    std::vector<std::size_t> found;
    tree.FindWithin(at_m, kRadius_m, &found);
    EXPECT_THAT(found, ::testing::UnorderedElementsAreArray(within));
  }
}

}  // namespace dn::matching_internal
