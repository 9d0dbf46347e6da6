#include <dn/error.h>
#include <dn/matching/strip_planes.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "testing/roofs.h"

namespace dn::matching_test {

using Eigen::Vector3d;

constexpr double kSpacingM = 0.5;
constexpr double kNoiseM = 0.02;
constexpr double kSlopeRad = 0.5;

/// Strips over a village in memory; x is the position.
class Village : public MatchSource {
 public:
  /// first_m: start of each strip; all strips are 200 m long and wide.
  explicit Village(const std::vector<double>& first_m) {
    for (double e = 20.0; e < 480.0; e += 33.0) {
      for (double n = 17.0; n < 200.0; n += 41.0) {
        roofs_.push_back({{e, n}, 12.0, 6.0, kSlopeRad, 5.0, 0.3 * e});
      }
    }
    for (std::size_t s = 0; s < first_m.size(); ++s) {
      strips_.push_back({std::to_string(s + 1), {}});
      Scan(first_m[s], static_cast<unsigned>(s));
    }
  }

  const std::vector<MatchStrip>& strips() const override { return strips_; }
  StripCounts Read(std::size_t strip,
                   const std::function<void(const RawPoints&)>& take) const override {
    take(points_[strip]);
    return {};
  }
  Vector3d Position(std::size_t, double, const Vector3d& x) const override { return x; }
  Vector3d RawAt(std::size_t, double, const Vector3d& p_m) const override { return p_m; }

 private:
  void Scan(double first_m, unsigned seed) {
    std::mt19937 rng(seed);
    std::normal_distribution<double> noise(0.0, kNoiseM);
    std::uniform_real_distribution<double> jitter(-0.1, 0.1);
    RawPoints& points = points_.emplace_back();
    for (double e = 0.0; e < 200.0; e += kSpacingM) {
      for (double n = 0.0; n < 200.0; n += kSpacingM) {
        const Eigen::Vector2d en(first_m + e + jitter(rng), n + jitter(rng));
        points.t_s.push_back(e);
        points.x.emplace_back(en.x(), en.y(), testing::SurfaceHeight(roofs_, en) + noise(rng));
      }
    }
  }

  std::vector<testing::Roof> roofs_;
  std::vector<MatchStrip> strips_;
  std::vector<RawPoints> points_;
};

std::vector<PlanarRegion> Sloping(const std::vector<StripPlane>& planes) {
  std::vector<PlanarRegion> sloping;
  for (const StripPlane& plane : planes) {
    const PlanarRegion region = FitRegion(plane.u_s);
    if (std::acos(region.normal.z()) > 0.1) sloping.push_back(region);
  }
  return sloping;
}

TEST(ExtractStripPlanes, RoofsWhereStripsOverlap) {
  const Village village({0.0, 100.0});
  const StripPlanes planes = ExtractStripPlanes(village, {});
  ASSERT_EQ(planes.strips.size(), 2u);
  EXPECT_NEAR(planes.spacing_m, kSpacingM, 0.05);
  EXPECT_EQ(planes.share, 1.0);
  for (const auto& of_strip : planes.strips) {
    const std::vector<PlanarRegion> roofs = Sloping(of_strip);
    EXPECT_GE(roofs.size(), 20u);  // 3 x 5 houses of two sides, some cut by squares
    for (const PlanarRegion& roof : roofs) {
      EXPECT_NEAR(std::acos(roof.normal.z()), kSlopeRad, 0.03);
      EXPECT_GT(roof.centroid_m.x(), 99.0);
      EXPECT_LT(roof.centroid_m.x(), 201.0);
    }
    for (const StripPlane& plane : of_strip) {
      EXPECT_LE(plane.u_s.size(), 150u);
      EXPECT_NEAR(plane.rms_m, kNoiseM, 0.5 * kNoiseM);
    }
  }
}

TEST(ExtractStripPlanes, FewerPointsTakeAShareOfTheGround) {
  const Village village({0.0, 0.0});
  const StripPlanes half = ExtractStripPlanes(village, {.most_points = 80'000});
  EXPECT_NEAR(half.share, 0.5, 0.05);
  EXPECT_FALSE(half.strips[0].empty());
}

TEST(ExtractStripPlanes, ThreadsChangeNothing) {
  const Village village({0.0, 100.0});
  const StripPlanes one = ExtractStripPlanes(village, {});
  const StripPlanes three = ExtractStripPlanes(village, {.threads = 3});
  ASSERT_EQ(one.strips[1].size(), three.strips[1].size());
  for (std::size_t k = 0; k < one.strips[1].size(); ++k) {
    EXPECT_EQ(one.strips[1][k].u_s, three.strips[1][k].u_s);
  }
}

TEST(ExtractStripPlanes, NoOverlapIsAFinding) {
  EXPECT_THROW(ExtractStripPlanes(Village({0.0, 300.0}), {}), RankDeficient);
  EXPECT_THROW(ExtractStripPlanes(Village({0.0}), {}), RankDeficient);
}

}  // namespace dn::matching_test
