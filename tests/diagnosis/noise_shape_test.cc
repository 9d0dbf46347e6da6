#include "noise_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace dn::diagnosis_test {

using diagnosis_internal::CompareNoiseShapes;
using diagnosis_internal::NoiseShape;
using Eigen::Vector3d;

constexpr int kMeasurements = 2000;

/// Draws noise of one kind for all measurements.
template <class Draw>
std::vector<Vector3d> Make(const Draw& draw) {
  std::mt19937_64 random(11);
  std::vector<Vector3d> all;
  for (int k = 0; k < kMeasurements; ++k) all.push_back(draw(&random));
  return all;
}

template <class Distribution>
Vector3d DrawEach(Distribution distribution, std::mt19937_64* random) {
  Vector3d r;
  for (double& component : r) component = distribution(*random);
  return r;
}

Vector3d DrawNormal(std::mt19937_64* random) {
  return DrawEach(std::normal_distribution<double>(), random);
}

TEST(NoiseShape, IndependentTailsOfStudentAreNotOutliers) {
  const NoiseShape shape = CompareNoiseShapes(Make([](std::mt19937_64* random) {
    return Vector3d(1.5 * DrawEach(std::student_t_distribution<double>(4.0), random));
  }));
  EXPECT_LT(shape.outlier_lead_nats, -20.0);
  EXPECT_NEAR(shape.dof, 4.0, 1.0);
  EXPECT_NEAR(shape.scale, 1.5, 0.1);
}

TEST(NoiseShape, CommonTailsOfStudentAreNotOutliers) {
  const NoiseShape shape = CompareNoiseShapes(Make([](std::mt19937_64* random) {
    const double chi2 = std::chi_squared_distribution<double>(3.0)(*random);
    return Vector3d(DrawNormal(random) * std::sqrt(3.0 / chi2));
  }));
  EXPECT_LT(shape.outlier_lead_nats, -20.0);
  EXPECT_NEAR(shape.dof, 3.0, 0.6);
}

TEST(NoiseShape, OutliersAreNotTails) {
  const NoiseShape shape = CompareNoiseShapes(Make([](std::mt19937_64* random) {
    Vector3d r = DrawNormal(random);
    if (std::bernoulli_distribution(0.03)(*random)) {
      const double length = std::uniform_real_distribution<double>(0.0, 20.0)(*random);
      r += length * DrawNormal(random).normalized();
    }
    return r;
  }));
  EXPECT_GT(shape.outlier_lead_nats, 20.0);
}

TEST(NoiseShape, NormalNoiseOfAnotherSizeIsNeither) {
  const NoiseShape shape = CompareNoiseShapes(
      Make([](std::mt19937_64* random) { return Vector3d(1.3 * DrawNormal(random)); }));
  EXPECT_NEAR(shape.outlier_lead_nats, 0.0, 10.0);
}

}  // namespace dn::diagnosis_test
