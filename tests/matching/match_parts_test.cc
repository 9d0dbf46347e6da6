#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "agree_with_neighbours.h"
#include "fill_voids.h"
#include "height_raster.h"
#include "match_cells.h"
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
  EXPECT_LT((shift->shift_m - kShift_m).head<2>().norm(), 0.7);
  EXPECT_NEAR(shift->shift_m.z(), kShift_m.z(), 0.5);
}

TEST(FindShift, HasTheTiltOfThePiece) {
  const RoughTown town;
  const RasterGrid grid = Grid(150, 2.0);
  const std::vector<Vector3d> level = town.Points(60000, 300.0, 0.02, Vector3d::Zero(), 1);
  std::vector<Vector3d> tilted = town.Points(60000, 300.0, 0.02, Vector3d::Zero(), 2);
  for (Vector3d& p : tilted) p.z() += 0.01 * (p.x() - 150.0) - 0.02 * (p.y() - 150.0);
  const auto shift =
      FindShift(MakeRaster(grid, level, 0), MakeRaster(grid, tilted, 0), {75, 75}, 16, 6);
  ASSERT_TRUE(shift);
  // A cell is two metres wide.
  EXPECT_NEAR(shift->slope_m.x(), 0.02, 0.008);
  EXPECT_NEAR(shift->slope_m.y(), -0.04, 0.008);
  EXPECT_NEAR((shift->At({10, 0}) - shift->shift_m).z(), 10.0 * shift->slope_m.x(), 1e-12);
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

constexpr double kGsd_m = 0.5;
const GroundCell kCell{{62.0, 62.0}, 18.0};

/// Returns the surface of the points about a cell shifted by shift_m.
PatchSurface Surface(const std::vector<Vector3d>& points_m, const Vector3d& shift_m) {
  const Vector2d centre_m = kCell.centre_en_m + shift_m.head<2>();
  return {Around(points_m, centre_m, 1.5 * kCell.half_m), 3.0 * kGsd_m};
}

std::optional<Registration> RegisterTown(const RoughTown& town, unsigned seed) {
  const PatchSurface a =
      Surface(town.Points(90000, 150.0, 0.02, Vector3d::Zero(), 2 * seed), Vector3d::Zero());
  const PatchSurface b = Surface(town.Points(90000, 150.0, 0.02, kShift_m, 2 * seed + 1), kShift_m);
  return RegisterPatches(a, b, kShift_m + Vector3d(0.3, -0.25, 0.1), {kCell, kGsd_m, 8000});
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
  }
}

TEST(RegisterPatches, TheShiftIsThatOfTheCentreOfTheInformation) {
  constexpr double kTilt_rad = 2e-3;
  const RoughTown town;
  std::vector<Vector3d> west, tilted = town.Points(90000, 150.0, 0.02, Vector3d::Zero(), 2);
  for (const Vector3d& p_m : town.Points(90000, 150.0, 0.02, Vector3d::Zero(), 1)) {
    if (p_m.x() < kCell.centre_en_m.x()) west.push_back(p_m);
  }
  for (Vector3d& p_m : tilted) p_m.z() += kTilt_rad * (p_m.x() - kCell.centre_en_m.x());
  const auto registration =
      RegisterPatches(Surface(west, Vector3d::Zero()), Surface(tilted, Vector3d::Zero()),
                      Vector3d::Zero(), {kCell, kGsd_m, 8000});
  ASSERT_TRUE(registration);
  EXPECT_NEAR(registration->centre_en_m.x(), kCell.centre_en_m.x() - 0.5 * kCell.half_m, 2.0);
  EXPECT_NEAR(registration->shift_m.z(),
              kTilt_rad * (registration->centre_en_m.x() - kCell.centre_en_m.x()), 3e-3);
}

TEST(RegisterPatches, SayWhenADirectionIsFree) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const auto flat = RegisterTown(RoughTown(true), seed);
    if (flat) {  // the noise tilts the normals a little, which gives little information
      EXPECT_GT(std::sqrt(flat->Covariance(flat->variance_ratio).trace()), 0.02);
    }
  }
}

/// Crowns of clumps of leaves, through which some of the light reaches the ground.
class Forest {
 public:
  Forest() {
    std::mt19937_64 engine(3);
    std::uniform_real_distribution<double> place(0.0, kEdge_m), size(0.7, 1.3);
    for (int tree = 0; tree < 800; ++tree) {
      const double east_m = place(engine), north_m = place(engine);
      const Vector3d centre_m(east_m, north_m, 11.0 * size(engine));
      crowns_.emplace_back(centre_m, 2.0 * size(engine), &engine);
    }
  }

  std::vector<Vector3d> Points(int count, const Vector3d& shift_m, unsigned seed) const {
    std::mt19937_64 engine(seed);
    std::uniform_real_distribution<double> place(0.0, kEdge_m), share(0.0, 1.0);
    std::normal_distribution<double> normal;
    std::vector<Vector3d> points;
    for (int i = 0; i < count; ++i) {
      // One draw per statement: compilers evaluate arguments in different orders.
      const double up_m = 0.03 * normal(engine);
      const double north_m = place(engine), east_m = place(engine);
      Vector3d p_m(east_m, north_m, up_m);
      const Crown* above = Above(p_m);
      if (above != nullptr && share(engine) < 0.7) p_m = above->RandomPoint(&engine);
      points.push_back(p_m + shift_m);
    }
    return points;
  }

 private:
  static constexpr double kEdge_m = 124.0;

  struct Crown {
    Crown(const Vector3d& centre, double radius, std::mt19937_64* engine)
        : centre_m(centre), radius_m(radius) {
      std::normal_distribution<double> normal;
      std::exponential_distribution<double> depth(5.0);
      for (Vector3d& clump_m : clumps_m) {
        const double z = std::abs(normal(*engine)), y = normal(*engine), x = normal(*engine);
        const Vector3d up(x, y, z);
        const double share = 1.0 - std::min(1.0, depth(*engine));
        clump_m = centre + radius * share * up.normalized().cwiseProduct(Vector3d(1.0, 1.0, 2.0));
      }
    }

    Vector3d RandomPoint(std::mt19937_64* engine) const {
      std::normal_distribution<double> normal(0.0, 0.12);
      const double x = normal(*engine), y = normal(*engine), z = normal(*engine);
      return clumps_m[(*engine)() % clumps_m.size()] + Vector3d(x, y, z);
    }

    Vector3d centre_m;
    double radius_m;
    std::array<Vector3d, 60> clumps_m;
  };

  const Crown* Above(const Vector3d& p_m) const {
    for (const Crown& crown : crowns_) {
      if ((crown.centre_m - p_m).head<2>().norm() < crown.radius_m) return &crown;
    }
    return nullptr;
  }

  std::vector<Crown> crowns_;
};

/// Returns the surfaces of a forest seen twice, the second time shifted by kShift_m.
std::pair<PatchSurface, PatchSurface> SeenTwice(const Forest& forest, unsigned seed) {
  constexpr int kPoints = 62000;  // four per square metre
  return {Surface(forest.Points(kPoints, Vector3d::Zero(), 2 * seed), Vector3d::Zero()),
          Surface(forest.Points(kPoints, kShift_m, 2 * seed + 1), kShift_m)};
}

TEST(MatchCells, AForestIsDividedIntoCellsWithHonestCovariances) {
  const Forest forest;
  double normalised = 0.0, squares_m2 = 0.0, count = 0.0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const auto [a, b] = SeenTwice(forest, seed);
    const std::vector<CellMatch> matches =
        MatchCells(a, b, kShift_m + Vector3d(0.5, -0.4, 0.2), {kCell, kGsd_m, 3.0}).cells;
    EXPECT_GE(matches.size(), 10u);
    for (const CellMatch& match : matches) {
      const Vector3d error_m = match.registration.shift_m - kShift_m;
      const Eigen::Matrix3d C =
          match.registration.Covariance(std::max(1.0, match.registration.variance_ratio));
      normalised += error_m.dot(C.inverse() * error_m) / 3.0;
      squares_m2 += error_m.squaredNorm();
      count += 1.0;
    }
  }
  EXPECT_LT(std::sqrt(squares_m2 / count), 0.3 * kGsd_m);
  EXPECT_GT(normalised / count, 0.3);
  EXPECT_LT(normalised / count, 2.5);
}

TEST(MatchCells, DoNotOverlap) {
  const auto [a, b] = SeenTwice(Forest(), 1);
  const std::vector<CellMatch> matches = MatchCells(a, b, kShift_m, {kCell, kGsd_m, 3.0}).cells;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const double apart_m =
          (matches[i].cell.centre_en_m - matches[k].cell.centre_en_m).cwiseAbs().maxCoeff();
      EXPECT_GE(apart_m, matches[i].cell.half_m + matches[k].cell.half_m - 1e-9);
    }
  }
}

TEST(ChooseCells, AnyNumberOfThemIsSpreadOverTheArea) {
  const RoughTown town;
  const HeightRaster a =
      MakeRaster(Grid(150, 1.0), town.Points(90000, 150.0, 0.02, Vector3d::Zero(), 1), 6);
  const std::vector<GroundCell> cells = ChooseCells(a, a, 15);
  ASSERT_EQ(cells.size(), 100u);
  int west = 0, south = 0;
  for (int k = 0; k < 10; ++k) {
    west += cells[static_cast<std::size_t>(k)].centre_en_m.x() < 75.0 ? 1 : 0;
    south += cells[static_cast<std::size_t>(k)].centre_en_m.y() < 75.0 ? 1 : 0;
  }
  EXPECT_THAT(west, ::testing::AllOf(::testing::Ge(3), ::testing::Le(7)));
  EXPECT_THAT(south, ::testing::AllOf(::testing::Ge(3), ::testing::Le(7)));
}

TEST(ChooseCells, AreWhereBothStripsHavePoints) {
  const RoughTown town;
  const std::vector<Vector3d> points = town.Points(90000, 150.0, 0.02, Vector3d::Zero(), 1);
  std::vector<Vector3d> west;
  for (const Vector3d& p_m : points) {
    if (p_m.x() < 70.0) west.push_back(p_m);
  }
  const HeightRaster a = MakeRaster(Grid(150, 1.0), points, 0);
  const HeightRaster b = MakeRaster(Grid(150, 1.0), west, 0);
  EXPECT_EQ(ChooseCells(a, b, 15).size(), 50u);
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

TEST(AgreeWithNeighbours, AFewAccurateOnesAmongOthersAreNotWidened) {
  std::mt19937_64 engine(6);
  std::normal_distribution<double> normal;
  std::vector<PlacedShift> shifts = ScatteredShifts();
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    const double sigma_m = i % 10 == 0 ? 0.01 : 0.1;
    shifts[i].shift_m = kShift_m;
    for (int axis = 0; axis < 3; ++axis) shifts[i].shift_m[axis] += sigma_m * normal(engine);
    shifts[i].covariance_m2 = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  }
  const Agreement agreement = AgreeWithNeighbours(shifts);
  EXPECT_GE(std::count(agreement.agrees.begin(), agreement.agrees.end(), true), 195);
  EXPECT_LT(agreement.variance_factor, 1.2);
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

TEST(AgreeWithNeighbours, CovariancesGrowInTheDirectionThatDisagrees) {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  std::vector<PlacedShift> shifts = ScatteredShifts();
  const Vector3d along(0.6, 0.8, 0.0);
  for (PlacedShift& shift : shifts) {
    shift.shift_m = kShift_m + 0.15 * normal(engine) * along;
    for (int axis = 0; axis < 3; ++axis) shift.shift_m[axis] += 0.05 * normal(engine);
  }
  const Agreement agreement = AgreeWithNeighbours(shifts);
  const Eigen::Matrix3d C = agreement.Inflated(0.0025 * Eigen::Matrix3d::Identity());
  EXPECT_NEAR(along.dot(C * along), 0.025, 0.006);
  const Vector3d across(-0.8, 0.6, 0.0);
  EXPECT_NEAR(across.dot(C * across), 0.0025, 0.0015);
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
    std::sort(within.begin(), within.end(), [&](std::size_t p, std::size_t q) {
      return (points_m[p] - at_m).norm() < (points_m[q] - at_m).norm();
    });
    within.resize(std::min<std::size_t>(within.size(), 5));
    tree.FindNearest(at_m, 5, kRadius_m, &found);
    EXPECT_THAT(found, ::testing::UnorderedElementsAreArray(within));
  }
}

}  // namespace dn::matching_internal
