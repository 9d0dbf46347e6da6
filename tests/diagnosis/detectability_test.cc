#include "detectability.h"

#include <dn/solvers/fit_check.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dn::diagnosis_test {

using diagnosis_internal::Hypothesis;
using diagnosis_internal::Library;
using diagnosis_internal::MakeHypothesis;
using diagnosis_internal::TestFamily;

TEST(MinimalDetectableBias, IsInfiniteForAnAbsorbedSignature) {
  EXPECT_DOUBLE_EQ(diagnosis_internal::MinimalDetectableBias(4.0, 9.0),
                   0.5 * OutlierTest().NonCentrality());
  EXPECT_TRUE(std::isinf(diagnosis_internal::MinimalDetectableBias(1e-9, 1.0)));
  EXPECT_TRUE(std::isinf(diagnosis_internal::MinimalDetectableBias(0.0, 0.0)));
}

/// Hypotheses with one component each, whose score has this shift per typical size.
struct OneComponentEach {
  Library library;
  JointScore score;

  void Add(EffectId id, double information, double typical_shift) {
    const auto n = static_cast<Eigen::Index>(library.hypotheses.size());
    library.Add(MakeHypothesis(id), {});
    score.first = {0};
    for (Eigen::Index k = 0; k <= n; ++k) score.first.push_back(k + 1);
    const Hypothesis& added = library.hypotheses.back();
    score.A.conservativeResizeLike(Eigen::MatrixXd::Zero(n + 1, n + 1));
    score.A(n, n) = information / (added.typical[0] * added.typical[0]);
    score.signature2 = score.A.diagonal();
    score.shift.conservativeResizeLike(Eigen::MatrixXd::Zero(3, n + 1));
    score.shift(0, n) = typical_shift / added.typical[0];
  }

  std::vector<UndetectableEffect> Find() const {
    return FindUndetectable(library, score, TestFamily{1.0, Eigen::Vector3d::Ones(), true}, {});
  }
};

TEST(FindUndetectable, TakesHarmfulEffectsBelowTheirDetectableBias) {
  OneComponentEach flight;
  flight.Add(EffectId::kLidarTimeOffset, 1.0, 2.0);
  flight.Add(EffectId::kLidarTimeDrift, 1e4, 5.0);    // detectable
  flight.Add(EffectId::kLidarRangeOffset, 1.0, 0.5);  // harmless
  flight.Add(EffectId::kLidarRangeScale, 1e-2, 3.0);
  const std::vector<UndetectableEffect> found = flight.Find();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].name, "lidar_range_scale");
  EXPECT_NEAR(found[0].max_shift_sigmas, 3.0, 1e-12);
  EXPECT_NEAR(found[0].minimal_detectable / found[0].usual, 10.0 * OutlierTest().NonCentrality(),
              1e-9);
  EXPECT_EQ(found[1].name, "lidar_time_offset");
}

TEST(FindUndetectable, ListsANameOnceWithItsLargestShift) {
  OneComponentEach flight;
  flight.Add(EffectId::kLidarTimeOffset, 1.0, 2.0);
  flight.Add(EffectId::kLidarTimeOffset, 1.0, 4.0);
  const std::vector<UndetectableEffect> found = flight.Find();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].max_shift_sigmas, 4.0, 1e-12);
}

}  // namespace dn::diagnosis_test
