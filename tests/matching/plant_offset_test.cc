#include "plant_offset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>

namespace dn::matching_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kHeight_m = 600.0;
constexpr double kPairSigma_m = 0.05;
constexpr double kOffset_m = 0.16;
const Vector3d kBoresightError_rad(2e-4, -1e-4, 3e-4);

/// A line flown level along east or north through a point.
struct TestLine {
  Vector3d through_m;
  bool east = true;
  Vector3d attitude_error_rad = Vector3d::Zero();  ///< about the body axes
};

/// Returns the end of a pair at a ground point. The adjustment sees the attitude without its error.
GaussHelmertEnd MakeLineEnd(const TestLine& line, const Vector3d& p_m) {
  GaussHelmertEnd end;
  end.p_mb = line.through_m;
  end.p_mb[line.east ? 0 : 1] = p_m[line.east ? 0 : 1];
  const Eigen::Quaterniond q_mn(0.0, std::sqrt(0.5), std::sqrt(0.5), 0.0);  // north-east-down
  const Eigen::AngleAxisd heading(line.east ? std::numbers::pi / 2.0 : 0.0, Vector3d::UnitZ());
  end.q_mb = q_mn * Eigen::Quaterniond(heading);
  const Eigen::Quaterniond error(1.0, 0.5 * line.attitude_error_rad.x(),
                                 0.5 * line.attitude_error_rad.y(),
                                 0.5 * line.attitude_error_rad.z());
  const Eigen::Quaterniond boresight(1.0, 0.5 * kBoresightError_rad.x(),
                                     0.5 * kBoresightError_rad.y(), 0.5 * kBoresightError_rad.z());
  end.u_b = boresight.conjugate() * (error.conjugate() * (end.q_mb.conjugate() * (p_m - end.p_mb)));
  return end;
}

/// Returns pairs of two lines with the offset, in forest of this volumetric share.
std::vector<PlantPair> MakeForest(const std::vector<TestLine>& lines, std::size_t i, std::size_t j,
                                  double share, std::mt19937_64* engine) {
  std::uniform_real_distribution<double> uniform(-150.0, 150.0);
  std::normal_distribution<double> normal(0.0, kPairSigma_m);
  std::vector<PlantPair> pairs;
  for (int k = 0; k < 300; ++k) {
    const double east_m = uniform(*engine), north_m = uniform(*engine);
    const Vector3d p_m(east_m, north_m, 0.0);
    PlantPair pair;
    pair.strip_i = i;
    pair.strip_j = j;
    pair.volumetric_share = Vector3d(share, share, 0.0).asDiagonal();
    pair.pair.j = MakeLineEnd(lines[j], p_m);
    pair.pair.covariance_m2 = kPairSigma_m * kPairSigma_m * Matrix3d::Identity();
    pair.beam_i = (p_m - MakeLineEnd(lines[i], p_m).p_mb).normalized();
    pair.beam_j = (p_m - pair.pair.j.p_mb).normalized();
    Vector3d off_m = kOffset_m * pair.Effect();
    for (int axis = 0; axis < 3; ++axis) off_m[axis] += normal(*engine);
    pair.pair.i = MakeLineEnd(lines[i], p_m);
    pair.pair.i.u_b += pair.pair.i.q_mb.conjugate() * off_m;
    pairs.push_back(pair);
  }
  return pairs;
}

const std::vector<TestLine> kLines{
    {Vector3d(0, -80, kHeight_m), true, Vector3d(5e-5, -8e-5, 4e-5)},
    {Vector3d(0, 80, kHeight_m), true, Vector3d(-7e-5, 3e-5, -9e-5)},
    {Vector3d(40, 0, kHeight_m + 20.0), false, Vector3d(2e-5, 6e-5, 3e-5)}};

PlantOptions Options() {
  PlantOptions options;
  options.offset_sigma_m = 0.25;
  options.strips = kLines.size();
  return options;
}

TEST(EstimatePlantOffset, CrossingStripsTellItFromBoresightAndTrajectoryErrors) {
  std::mt19937_64 engine(11);
  std::vector<PlantPair> pairs = MakeForest(kLines, 0, 1, 1.0, &engine);
  for (const std::size_t i : {0, 1}) {
    const std::vector<PlantPair> crossing = MakeForest(kLines, i, 2, 0.8, &engine);
    pairs.insert(pairs.end(), crossing.begin(), crossing.end());
  }
  const PlantOffset found = EstimatePlantOffset(pairs, Options());
  EXPECT_LT(found.sigma_m, 0.05);
  EXPECT_NEAR(found.offset_m, kOffset_m, 0.03);
}

TEST(EstimatePlantOffset, ParallelStripsAloneKeepMostOfThePriorSigma) {
  std::mt19937_64 engine(12);
  const PlantOffset found = EstimatePlantOffset(MakeForest(kLines, 0, 1, 1.0, &engine), Options());
  EXPECT_GT(found.sigma_m, 0.5 * Options().offset_sigma_m);
  EXPECT_LT(std::abs(found.offset_m - kOffset_m), 3.0 * found.sigma_m);
}

TEST(EstimatePlantOffset, HardGroundSaysNothingAboutIt) {
  std::mt19937_64 engine(13);
  const PlantOffset found = EstimatePlantOffset(MakeForest(kLines, 0, 2, 0.0, &engine), Options());
  EXPECT_EQ(found.offset_m, 0.0);
  EXPECT_NEAR(found.sigma_m, Options().offset_sigma_m, 1e-9);
}

}  // namespace
}  // namespace dn::matching_internal
