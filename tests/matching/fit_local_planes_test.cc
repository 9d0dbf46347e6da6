#include <dn/error.h>
#include <dn/matching/point_cloud.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <limits>
#include <random>

namespace dn::matching_test {

// Coordinates of 1e3 m have a rounding of 1e-13 m, so that a normal over some metres is accurate to
// 1e-12; the rest is margin.
constexpr double kRounding = 1e-10;

/// Returns a grid of (2 half + 1)^2 points 0.5 m apart on the plane through `centre_m` with unit
/// normal n.
std::vector<Eigen::Vector3d> PlaneGrid(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& n,
                                       int half) {
  const Eigen::Vector3d a = n.unitOrthogonal(), b = n.cross(a);
  std::vector<Eigen::Vector3d> points_m;
  for (int i = -half; i <= half; ++i) {
    for (int j = -half; j <= half; ++j) points_m.push_back(centre_m + 0.5 * i * a + 0.5 * j * b);
  }
  return points_m;
}

TEST(FitLocalPlanes, RecoversARoofFarFromTheOrigin) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    std::normal_distribution<double> normal;
    Eigen::Vector3d n = Eigen::Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
    if (n.z() < 0.0) n = -n;
    const Eigen::Vector3d centre_m(4000.0, -3000.0, 800.0);
    const std::vector<Eigen::Vector3d> points_m = PlaneGrid(centre_m, n, 10);
    const std::size_t middle = points_m.size() / 2;

    const std::vector<LocalPlane> planes = FitLocalPlanes(points_m, {middle}, 1.75);
    ASSERT_EQ(planes.size(), 1u);
    EXPECT_EQ(planes[0].neighbours, 37u);  // lattice points within 3.5 steps
    EXPECT_LE((planes[0].normal - n).norm(), kRounding);
    EXPECT_LE((planes[0].centroid_m - centre_m).norm(), kRounding);
    EXPECT_LE(planes[0].rms_m, 1e-6);                  // square root of a rounding of 1e-13 m^2
    EXPECT_NEAR(planes[0].planarity, 1.0, kRounding);  // the symmetry of the lattice gives l1 = l2
  }
}

TEST(FitLocalPlanes, RmsIsThatOfTheDistances) {
  std::vector<Eigen::Vector3d> points_m = PlaneGrid({0, 0, 0}, Eigen::Vector3d::UnitZ(), 4);
  for (std::size_t i = 0; i < points_m.size(); ++i) points_m[i].z() = (i % 2 == 0) ? 0.1 : -0.1;
  const std::vector<LocalPlane> planes = FitLocalPlanes(points_m, {40}, 100.0);
  EXPECT_EQ(planes.at(0).neighbours, points_m.size());
  EXPECT_NEAR(planes.at(0).rms_m, 0.1, 1e-5);  // 41 above, 40 below: the mean is 0.1/81 m off zero
}

TEST(FitLocalPlanes, NoPlaneOnALineOrAlone) {
  std::vector<Eigen::Vector3d> line_m;
  for (int i = 0; i < 9; ++i) line_m.push_back(Eigen::Vector3d(1.0, 2.0, 0.5) * i);
  line_m.emplace_back(1000.0, 0.0, 0.0);
  const std::vector<LocalPlane> planes = FitLocalPlanes(line_m, {4, 9}, 5.0);
  EXPECT_EQ(planes.at(0).neighbours, 5u);  // |(1, 2, 0.5)| = 2.29 m
  EXPECT_TRUE(planes[0].normal.isZero(0.0));
  EXPECT_EQ(planes[0].planarity, 0.0);
  EXPECT_EQ(planes.at(1).neighbours, 1u);
  EXPECT_TRUE(planes[1].normal.isZero(0.0));
}

TEST(FitLocalPlanes, ABallIsNotPlanar) {
  std::mt19937 rng(5);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> points_m;
  for (int i = 0; i < 3000; ++i) points_m.emplace_back(normal(rng), normal(rng), normal(rng));
  points_m[0].setZero();
  const LocalPlane plane = FitLocalPlanes(points_m, {0}, 50.0).at(0);
  EXPECT_LT(plane.planarity, 0.15);  // eigenvalues of 3000 samples scatter by sqrt(2/3000)
  EXPECT_NEAR(plane.rms_m, 1.0, 0.1);
}

TEST(FitLocalPlanes, RejectsBadInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Eigen::Vector3d> points_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_THROW(FitLocalPlanes(points_m, {0}, 0.0), InvalidInput);
  EXPECT_THROW(FitLocalPlanes(points_m, {0}, nan), InvalidInput);
  EXPECT_THROW(FitLocalPlanes(points_m, {3}, 1.0), InvalidInput);
  EXPECT_THROW(FitLocalPlanes({{nan, 0, 0}}, {0}, 1.0), InvalidInput);
  EXPECT_TRUE(FitLocalPlanes({}, {}, 1.0).empty());
}

}  // namespace dn::matching_test
