#include <dn/matching/loop_redundancy.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dn::matching_test {

/// Adds a pair of strips i and j at a place, with the identity as its covariance.
void AddPairAt(std::size_t i, std::size_t j, double east_m, double north_m, MatchResult* result) {
  StripPairMatch match;
  match.i = i;
  match.j = j;
  MatchedPair pair;
  pair.p_j_m = {east_m, north_m, 0.0};
  pair.radius_m = 2.0;
  pair.pair.covariance_m2 = Eigen::Matrix3d::Identity();
  match.pairs.push_back(pair);
  result->strip_pairs.push_back(match);
}

std::vector<double> InflatedVariances(MatchResult result) {
  InflateLoops(&result);
  std::vector<double> variances;
  for (const StripPairMatch& match : result.strip_pairs) {
    for (const MatchedPair& pair : match.pairs) {
      variances.push_back((*pair.pair.covariance_m2)(0, 0));
    }
  }
  return variances;
}

TEST(InflateLoops, PairsWithoutALoopKeepTheirCovariance) {
  MatchResult result;
  AddPairAt(0, 1, 0.0, 0.0, &result);
  AddPairAt(1, 2, 1.0, 0.0, &result);
  AddPairAt(4, 3, 0.0, 1.0, &result);
  EXPECT_EQ(InflatedVariances(result), (std::vector<double>{1.0, 1.0, 1.0}));
}

TEST(InflateLoops, ThreeStripsAreTwoDifferences) {
  MatchResult result;
  AddPairAt(0, 1, 0.0, 0.0, &result);
  AddPairAt(1, 2, 1.0, 0.0, &result);
  AddPairAt(0, 2, 0.0, 1.0, &result);
  EXPECT_EQ(InflatedVariances(result), (std::vector<double>{1.5, 1.5, 1.5}));
}

// A surface has the height of a place as a pair does, so that it closes a loop.
TEST(InflateLoops, SurfacesCountAsPairsDo) {
  MatchResult result;
  AddPairAt(0, 1, 0.0, 0.0, &result);
  AddPairAt(1, 2, 1.0, 0.0, &result);
  StripPairMatch third;
  third.i = 0;
  third.j = 2;
  MatchedSurface surface;
  surface.p_j_m = {0.0, 1.0, 0.0};
  surface.radius_m = 2.0;
  surface.pair.sigma_m = 0.1;
  third.surfaces = {surface};
  result.strip_pairs.push_back(third);
  EXPECT_EQ(InflatedVariances(result), (std::vector<double>{1.5, 1.5}));
  InflateLoops(&result);
  EXPECT_NEAR(result.strip_pairs[2].surfaces[0].pair.sigma_m, 0.1 * std::sqrt(1.5), 1e-12);
}

TEST(InflateLoops, FourStripsAreThreeDifferences) {
  MatchResult result;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) AddPairAt(i, j, 0.0, 0.0, &result);
  }
  EXPECT_EQ(InflatedVariances(result), std::vector<double>(6, 2.0));
}

TEST(InflateLoops, OtherPlacesDoNotCount) {
  MatchResult result;
  AddPairAt(0, 1, 0.0, 0.0, &result);
  AddPairAt(1, 2, 3.0, 0.0, &result);  // overlaps the first cell
  AddPairAt(0, 2, 3.0, 9.0, &result);  // overlaps none
  AddPairAt(0, 1, -50.0, 0.0, &result);
  EXPECT_EQ(InflatedVariances(result), std::vector<double>(4, 1.0));
}

TEST(InflateLoops, SeveralPairsOfTwoStripsAreNoLoop) {
  MatchResult result;
  AddPairAt(0, 1, 0.0, 0.0, &result);
  AddPairAt(0, 1, 1.0, 0.0, &result);
  EXPECT_EQ(InflatedVariances(result), (std::vector<double>{1.0, 1.0}));
}

}  // namespace dn::matching_test
