#include <dn/error.h>
#include <dn/matching/point_cloud.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <tuple>

namespace dn::matching_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Cell = std::tuple<long, long, long>;

Cell CellIndices(const Eigen::Vector3d& p_m, double voxel_m) {
  return {std::lround(std::floor(p_m.x() / voxel_m)), std::lround(std::floor(p_m.y() / voxel_m)),
          std::lround(std::floor(p_m.z() / voxel_m))};
}

double DistanceToCentre(const Eigen::Vector3d& p_m, double voxel_m) {
  const Eigen::Array3d cell = (p_m.array() / voxel_m).floor();
  return (p_m.array() - (cell + 0.5) * voxel_m).matrix().norm();
}

/// Returns random points away from the faces of the cells, because the cell of a point is only
/// defined to 1e-4.
std::vector<Eigen::Vector3d> PointsInsideCells(unsigned seed, int n,
                                               const Eigen::Vector3d& extent_m, double voxel_m) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> anywhere(-0.5, 0.5), inside(1e-3, 1.0 - 1e-3);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < n; ++i) {
    Eigen::Vector3d p_m;
    for (int k = 0; k < 3; ++k) {
      p_m[k] = (std::floor(anywhere(rng) * extent_m[k] / voxel_m) + inside(rng)) * voxel_m;
    }
    points_m.push_back(p_m);
  }
  return points_m;
}

TEST(ThinByVoxel, KeepsThePointNearestToTheCentre) {
  const std::vector<Eigen::Vector3d> points_m = {
      {0.1, 0.1, 0.1}, {0.9, 1.1, 1.0}, {1.9, 1.9, 1.9}, {-0.1, 0.5, 0.5}, {5.0, 5.0, 5.0}};
  EXPECT_THAT(ThinByVoxel(points_m, 2.0), ElementsAre(1, 3, 4));
}

TEST(ThinByVoxel, NoPointsGiveNone) { EXPECT_TRUE(ThinByVoxel({}, 1.0).empty()); }

// Checks against an independent count with a plain map. The strip is far larger than the limit of
// 2^31 cells of PCL, and far from the origin of the frame.
TEST(ThinByVoxel, OnePointPerOccupiedCellOverALargeStrip) {
  constexpr double kVoxel_m = 0.25;
  // Coordinates of 1e3 cells in float have a rounding of 6e-5 cells, squared distances of 1e-4.
  constexpr double kTieTolerance_m = 2e-4 * kVoxel_m;
  for (unsigned seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::vector<Eigen::Vector3d> points_m =
        PointsInsideCells(seed, 20000, {6000.0, 2000.0, 400.0}, kVoxel_m);
    const std::vector<Eigen::Vector3d> dense_m =
        PointsInsideCells(seed + 100, 20000, {4.0, 4.0, 4.0}, kVoxel_m);
    for (const Eigen::Vector3d& p_m : dense_m) {
      points_m.push_back(p_m + Eigen::Vector3d(20000.0, -5000.0, 300.0));
    }

    std::map<Cell, double> nearest_m;
    for (const Eigen::Vector3d& p_m : points_m) {
      const double d_m = DistanceToCentre(p_m, kVoxel_m);
      const auto [it, inserted] = nearest_m.emplace(CellIndices(p_m, kVoxel_m), d_m);
      if (!inserted) it->second = std::min(it->second, d_m);
    }

    const std::vector<std::size_t> kept = ThinByVoxel(points_m, kVoxel_m);
    ASSERT_EQ(kept.size(), nearest_m.size());
    EXPECT_LT(kept.size(), points_m.size());
    EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
    std::map<Cell, int> count;
    for (const std::size_t i : kept) {
      const Cell cell = CellIndices(points_m[i], kVoxel_m);
      EXPECT_EQ(++count[cell], 1);
      EXPECT_NEAR(DistanceToCentre(points_m[i], kVoxel_m), nearest_m.at(cell), kTieTolerance_m);
    }
  }
}

TEST(ThinByVoxel, RejectsBadInputByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Eigen::Vector3d> points_m = {{0, 0, 0}, {0, nan, 0}};
  EXPECT_THROW(ThinByVoxel({{0, 0, 0}}, 0.0), InvalidInput);
  EXPECT_THROW(ThinByVoxel({{0, 0, 0}}, -1.0), InvalidInput);
  EXPECT_THROW(ThinByVoxel({{0, 0, 0}}, nan), InvalidInput);
  EXPECT_THROW(ThinByVoxel({{1e10, 0, 0}}, 1e-6), InvalidInput);
  try {
    ThinByVoxel(points_m, 1.0);
    FAIL() << "a NaN was accepted";
  } catch (const InvalidInput& e) {
    EXPECT_THAT(e.what(), HasSubstr("point 1 of 2"));
  }
}

}  // namespace dn::matching_test
