#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "solvers/step_factor.h"

namespace dn::solvers_test {

using testing::Step;

/// A cube of points with exact measured differences between neighbours; one point is constant.
struct Cube {
  explicit Cube(int side) {
    for (int i = 0; i < side * side * side; ++i) {
      truth.emplace_back(i % side, i / side % side, 0.1 * (i % 7));
      const Eigen::Vector3d start = i == 0 ? truth[0] : Eigen::Vector3d::Zero();
      points.push_back(net.AddVector<3>("p" + std::to_string(i), start));
    }
    net.Hold(points[0]);
    for (int i = 0; i < side * side * side; ++i) {
      if (i % side + 1 < side) Connect(i, i + 1);
      if (i / side % side + 1 < side) Connect(i, i + side);
      if (i / (side * side) + 1 < side) Connect(i, i + side * side);
    }
  }
  void Connect(int i, int j) {
    Step f;
    f.z = truth[static_cast<std::size_t>(j)] - truth[static_cast<std::size_t>(i)];
    net.Add(f, points[static_cast<std::size_t>(i)], points[static_cast<std::size_t>(j)]);
  }

  Network net;
  std::vector<Eigen::Vector3d> truth;
  std::vector<Block<Vec<3>>> points;
};

// A cube that is large enough for nested dissection.
TEST(LargeNetwork, IsSolvedInTheOrderOfItsDissection) {
  constexpr int kSide = 28;
  Cube cube(kSide);
  SolveOptions options;
  options.initial_trust_region_radius = 1e12;
  const SolveSummary summary = Solve(cube.net, options);
  EXPECT_TRUE(summary.converged) << summary.message;
  double worst = 0.0;
  for (std::size_t i = 0; i < cube.points.size(); ++i) {
    worst = std::max(worst, (cube.net.Value(cube.points[i]) - cube.truth[i]).norm());
  }
  EXPECT_LT(worst, 1e-7);
}

}  // namespace dn::solvers_test
