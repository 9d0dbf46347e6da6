#include "hypothesis.h"

#include <gtest/gtest.h>

#include <Eigen/Core>

namespace dn::diagnosis_test {

using diagnosis_internal::CellRange;
using diagnosis_internal::Hypothesis;
using diagnosis_internal::Library;

/// A block of nine columns on one factor, with its score if nothing else is unknown.
struct OneBlock {
  Library library;
  JointScore score;

  OneBlock() {
    const Eigen::MatrixXd L = Eigen::MatrixXd::Random(20, 9);
    library.AddBlock({{0, L}});
    score.first = {0, 9};
    score.s = L.transpose() * Eigen::VectorXd::Random(20);
    score.A = L.transpose() * L;
    score.signature2 = score.A.diagonal();
    score.shift = Eigen::MatrixXd::Random(3, 9);
  }
};

Hypothesis Cells(const CellRange& cells) {
  return diagnosis_internal::MakeDiscrepancy("cells", 0, cells, Eigen::Vector3d::Ones());
}

TEST(Hypothesis, InformationIsThatOfTheColumns) {
  const OneBlock block;
  const Hypothesis last = Cells({1, 3}), all = Cells({0, 3});
  const Eigen::MatrixXd L_last = SelectColumns(last, block.library).front().L;
  const Eigen::MatrixXd L_all = SelectColumns(all, block.library).front().L;
  ASSERT_EQ(L_last.cols(), 3);
  constexpr double kRounding = 1e-13;
  EXPECT_LT((SelectInformation(last, block.score) - L_last.transpose() * L_last).norm(), kRounding);
  EXPECT_LT((SelectInformation(last, all, block.score) - L_last.transpose() * L_all).norm(),
            kRounding);
}

TEST(Hypothesis, CellsOfTheirOwnAreAPartOfTheBlock) {
  const OneBlock block;
  const Hypothesis two = Cells({1, 3, 3, false});
  EXPECT_EQ(SelectScore(two, block.score, block.score.s), block.score.s.tail(6));
  EXPECT_EQ(SelectShift(two, block.score), block.score.shift.rightCols(6));
  EXPECT_EQ(SelectInformation(two, block.score), block.score.A.bottomRightCorner(6, 6));
}

TEST(Hypothesis, OfATableHasItsUnitAndNoTimeConstant) {
  const Hypothesis drift = diagnosis_internal::MakeHypothesis(EffectId::kLidarTimeDrift);
  EXPECT_EQ(drift.unit, "ppm");
  EXPECT_NEAR(drift.per_si, 1e6, 1e-6);
  const Hypothesis process = diagnosis_internal::MakeHypothesis(EffectId::kGyroBiasProcess, 4);
  EXPECT_EQ(process.block, 4U);
  EXPECT_EQ(process.typical.size() + 1,
            static_cast<Eigen::Index>(EffectRow(EffectId::kGyroBiasProcess).components.size()));
}

}  // namespace dn::diagnosis_test
