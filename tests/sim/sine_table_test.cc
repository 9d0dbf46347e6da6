#include "sine_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace dn::sim_test {

TEST(SineTable, AgreesWithTheStandardLibraryAtAllAngles) {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  const SineTable table;
  std::mt19937_64 random(1);
  for (const double largest_rad : {1.0, 1e3, 1e7}) {
    std::uniform_real_distribution<double> angle(-largest_rad, largest_rad);
    for (int i = 0; i < 20000; ++i) {
      const double angle_rad = angle(random);
      const CosineAndSine at = table.At(angle_rad);
      const double tolerance = 4.0 * kEpsilon * (1.0 + std::abs(angle_rad));
      ASSERT_NEAR(at.cosine, std::cos(angle_rad), tolerance) << angle_rad;
      ASSERT_NEAR(at.sine, std::sin(angle_rad), tolerance) << angle_rad;
    }
  }
}

}  // namespace dn::sim_test
