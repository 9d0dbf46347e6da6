#include <dn/adjustment/facets.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace dn::adjustment_test {

using Eigen::Vector3d;

constexpr double kNoiseM = 0.015;

/// A height over the ground plane.
using Shape = double (*)(double east_m, double north_m);

/// A pyramid of 1 m height on level ground, with its peak at the origin.
double Pyramid(double east_m, double north_m) {
  return std::max(-1.0, -std::max(std::abs(east_m), std::abs(north_m)));
}

/// The sides of a gabled roof that ends at north_m = 0, above ground 5 m lower.
double Gable(double east_m, double north_m) {
  return north_m > 0.0 ? -5.0 : -0.6 * std::abs(east_m);
}

/// Returns what a laser sees of a shape from straight above.
std::vector<NearReturn> Scan(Shape shape, double half_m, int count, std::mt19937& rng) {
  std::uniform_real_distribution<double> place(-half_m, half_m);
  std::normal_distribution<double> noise(0.0, kNoiseM);
  std::vector<NearReturn> returns;
  for (int k = 0; k < count; ++k) {
    const double east_m = place(rng), north_m = place(rng);
    returns.push_back(
        {Vector3d(east_m, north_m, shape(east_m, north_m) + noise(rng)), 0.0, Vector3d::Zero()});
  }
  return returns;
}

/// Adds returns of the wall below the gable.
void AddWall(int count, std::mt19937& rng, std::vector<NearReturn>* returns) {
  std::uniform_real_distribution<double> across(-2.0, 2.0), down(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, kNoiseM);
  for (int k = 0; k < count; ++k) {
    const double east_m = across(rng);
    const double up_m = -0.6 * std::abs(east_m) - 2.0 * down(rng);
    returns->push_back({Vector3d(east_m, noise(rng), up_m), 0.0, Vector3d::Zero()});
  }
}

/// Sums over facets of simulated targets whose corner is the origin.
struct FacetErrors {
  double facets = 0.0, squares = 0.0, roofs = 0.0, distance_m = 0.0;

  void Add(const std::vector<SurfaceFit>& found, const Vector3d& at_m) {
    for (const SurfaceFit& facet : found) {
      // The plane passes the true corner.
      const double error_m = facet.normal_m.dot(facet.foot_m);
      facets += 1.0;
      squares += error_m * error_m / (facet.sigma_m * facet.sigma_m);
      // The sign of a wall's normal depends on its error.
      if (facet.normal_m.z() < 0.1) continue;
      roofs += 1.0;
      distance_m += error_m;
      EXPECT_NEAR(facet.normal_m.cross(facet.foot_m - at_m).norm(), 0.0, 1e-12);
    }
  }
};

TEST(Facets, OfAPyramidMeetAtItsPeak) {
  constexpr int kRuns = 200;
  FacetErrors errors;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    const Vector3d at_m(0.03, -0.02, 0.04);  // the surveyed corner
    const std::vector<SurfaceFit> found = FindFacets(Scan(Pyramid, 2.5, 1100, rng), at_m, 1.5);
    ASSERT_GE(found.size(), 3u);
    std::vector<Vector3d> normals;
    for (const SurfaceFit& facet : found) {
      EXPECT_NEAR(facet.normal_m.z(), std::sqrt(0.5), 0.05);
      normals.push_back(facet.normal_m);
    }
    EXPECT_TRUE(DetermineCorner(normals));
    errors.Add(found, at_m);
  }
  EXPECT_GE(errors.facets, 3.95 * kRuns);
  // Four standard deviations of the mean square of 800 facets, and a tenth of the noise.
  EXPECT_NEAR(errors.squares / errors.facets, 1.0, 0.25);
  EXPECT_NEAR(errors.distance_m / errors.roofs, 0.0, 0.1 * kNoiseM);
}

TEST(Facets, OfAGableAreTwoSidesAndTheWall) {
  constexpr int kRuns = 200;
  FacetErrors errors;
  int walls = 0;
  for (unsigned seed = 1; seed <= kRuns; ++seed) {
    std::mt19937 rng(seed);
    std::vector<NearReturn> returns = Scan(Gable, 3.5, 500, rng);
    AddWall(40, rng, &returns);
    const std::vector<SurfaceFit> found = FindFacets(returns, Vector3d::Zero(), 2.0);
    EXPECT_LE(found.size(), 3u);
    for (const SurfaceFit& facet : found) walls += std::abs(facet.normal_m.y()) > 0.95 ? 1 : 0;
    errors.Add(found, Vector3d::Zero());
  }
  EXPECT_GE(walls, 9 * kRuns / 10);
  EXPECT_GE(errors.facets, 2.9 * kRuns);
  EXPECT_NEAR(errors.squares / errors.facets, 1.0, 0.25);
  EXPECT_NEAR(errors.distance_m / errors.roofs, 0.0, 0.1 * kNoiseM);
}

// Lines of a scanner are much further apart than the points on a line.
TEST(Facets, OfSparseLinesAreFound) {
  std::mt19937 rng(1);
  std::normal_distribution<double> noise(0.0, kNoiseM);
  std::vector<NearReturn> returns;
  for (double north_m = -1.95; north_m < 2.0; north_m += 0.3) {
    for (double east_m = -2.0; east_m < 2.0; east_m += 0.04) {
      returns.push_back({Vector3d(east_m, north_m, Pyramid(east_m, north_m) + noise(rng)), 0.0,
                         Vector3d::Zero()});
    }
  }
  const std::vector<SurfaceFit> found = FindFacets(returns, Vector3d::Zero(), 1.5);
  EXPECT_EQ(found.size(), 4u);
}

TEST(Facets, GroundBelowOrPlantsHaveNone) {
  std::mt19937 rng(1);
  const std::vector<NearReturn> ground = Scan(Pyramid, 2.0, 600, rng);
  EXPECT_TRUE(FindFacets({}, Vector3d::Zero(), 1.5).empty());
  EXPECT_TRUE(FindFacets(ground, Vector3d(0.0, 0.0, 8.0), 1.5).empty());
  // A metre beside the peak, only one side passes the point.
  const std::vector<SurfaceFit> beside = FindFacets(ground, Vector3d(0.6, 0.0, -0.6), 0.7);
  ASSERT_EQ(beside.size(), 1u);
  EXPECT_FALSE(DetermineCorner({beside.front().normal_m}));
  std::uniform_real_distribution<double> place(-1.5, 1.5);
  std::vector<NearReturn> plant;
  for (int k = 0; k < 500; ++k) {
    plant.push_back({Vector3d(place(rng), place(rng), place(rng)), 0.0, Vector3d::Zero()});
  }
  EXPECT_TRUE(FindFacets(plant, Vector3d::Zero(), 1.5).empty());
}

TEST(Facets, ThreeDirectionsDetermineACorner) {
  const Vector3d east(0.6, 0.0, 0.8), west(-0.6, 0.0, 0.8), wall(0.0, 1.0, 0.0);
  EXPECT_TRUE(DetermineCorner({east, west, wall}));
  EXPECT_FALSE(DetermineCorner({east, west}));
  EXPECT_FALSE(DetermineCorner({east, wall, wall}));
  EXPECT_FALSE(DetermineCorner({}));
}

}  // namespace dn::adjustment_test
