#include <dn/matching/shared_planes.h>
#include <gtest/gtest.h>

#include <map>

#include "testing/strip_planes.h"

namespace dn::matching_test {

using Eigen::Vector3d;

/// The planes of a simulated flight as each strip sees them, in a different order per strip; truth:
/// index of the true plane.
struct Strips {
  std::vector<std::vector<PlacedPlane>> planes{3};
  std::vector<std::vector<std::size_t>> truth{3};
};

Strips Part(const PlaneProblem& problem) {
  Strips strips;
  for (std::size_t k = 0; k < problem.planes.size(); ++k) {
    const std::size_t q = (17 * k) % problem.planes.size();
    std::map<std::size_t, PlacedPlane> parts;
    for (const PlanePoint& point : problem.planes[q].points) {
      parts[static_cast<std::size_t>(point.strip)].points.push_back(point.end);
    }
    for (auto& [s, part] : parts) {
      strips.planes[s].push_back(part);
      strips.truth[s].push_back(q);
    }
  }
  return strips;
}

/// Returns the fraction of correct matches and the fraction of matched planes.
std::pair<double, double> Score(const Strips& strips, const std::vector<std::vector<long>>& found,
                                std::size_t planes) {
  double right = 0.0;
  for (const std::vector<long>& members : found) {
    std::map<std::size_t, int> of;
    for (std::size_t s = 0; s < members.size(); ++s) {
      if (members[s] >= 0) ++of[strips.truth[s][static_cast<std::size_t>(members[s])]];
    }
    if (of.size() == 1 && of.begin()->second >= 2) right += 1.0;
  }
  return {right / static_cast<double>(found.size()), right / static_cast<double>(planes)};
}

TEST(MatchPlanes, JoinsWhatIsOnePlaneByTheTrueBoresight) {
  testing::StripPlaneOptions options;
  const PlaneProblem problem = testing::MakeStripPlanes(options);
  const Strips strips = Part(problem);
  const auto found =
      MatchPlanes(strips.planes, problem.lever_arm_b_m, options.flight.boresight_rad, 0.0, 0.07);
  const auto [right, complete] = Score(strips, found, problem.planes.size());
  EXPECT_EQ(right, 1.0);
  EXPECT_EQ(complete, 1.0);
}

TEST(MatchPlanes, MostAreRightBeforeTheBoresightIsKnown) {
  testing::StripPlaneOptions options;  // 0.4 deg: two strips are up to 4 m apart
  const PlaneProblem problem = testing::MakeStripPlanes(options);
  const Strips strips = Part(problem);
  const auto found =
      MatchPlanes(strips.planes, problem.lever_arm_b_m, Vector3d::Zero(), 6.0, 0.175);
  const auto [right, complete] = Score(strips, found, problem.planes.size());
  EXPECT_GT(right, 0.9);
  EXPECT_GT(complete, 0.8);
}

TEST(MatchPlanes, OtherNormalsAreOtherPlanes) {
  testing::StripPlaneOptions options;
  options.steepest_rad = 0.0;
  PlaneProblem level = testing::MakeStripPlanes(options);
  Strips strips = Part(level);
  for (auto& plane : strips.planes[1]) {  // one strip is tilted by 11 deg about each point
    for (GaussHelmertEnd& end : plane.points) {
      end.p_mb.z() += 0.2 * (end.q_mb * end.u_b + end.p_mb).x();
    }
  }
  const auto found =
      MatchPlanes(strips.planes, level.lever_arm_b_m, options.flight.boresight_rad, 0.0, 0.07);
  for (const auto& members : found) EXPECT_LT(members[1], 0);
}

}  // namespace dn::matching_test
