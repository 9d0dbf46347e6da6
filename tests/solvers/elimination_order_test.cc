#include "sparse/elimination_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace dn::solvers_test {

/// Returns the pattern of a cube of side^3 blocks, in which each block shares a factor with its
/// neighbours.
sparse::SymmetricCsc CubePattern(int side) {
  sparse::SymmetricCsc pattern;
  pattern.n = side * side * side;
  pattern.column_start.push_back(0);
  for (int i = 0; i < pattern.n; ++i) {
    pattern.row.push_back(i);
    if (i % side + 1 < side) pattern.row.push_back(i + 1);
    if (i / side % side + 1 < side) pattern.row.push_back(i + side);
    if (i / (side * side) + 1 < side) pattern.row.push_back(i + side * side);
    pattern.column_start.push_back(static_cast<int>(pattern.row.size()));
  }
  return pattern;
}

void ExpectPermutation(std::vector<int> order, int n) {
  std::vector<int> all(static_cast<std::size_t>(n));
  std::iota(all.begin(), all.end(), 0);
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order, all);
}

TEST(EliminationOrder, DissectsWhereMinimumDegreeLeavesMuchToDo) {
  constexpr int kSide = 24;
  const sparse::SymmetricCsc cube = CubePattern(kSide);
  const sparse::EliminationOrder order = sparse::FindEliminationOrder(cube, 6 * cube.n);
  EXPECT_TRUE(order.dissected);
  ExpectPermutation(order.position, cube.n);

  const sparse::EliminationOrder small_blocks = sparse::FindEliminationOrder(cube, cube.n);
  EXPECT_FALSE(small_blocks.dissected);
  ExpectPermutation(small_blocks.position, cube.n);
  EXPECT_LT(order.block_operations, 0.9 * small_blocks.block_operations);
}

// A chain of n blocks needs one multiplication per block in addition to the diagonal.
TEST(EliminationOrder, CountsTheOperations) {
  sparse::SymmetricCsc chain;
  chain.n = 1000;
  chain.column_start.push_back(0);
  for (int i = 0; i < chain.n; ++i) {
    chain.row.push_back(i);
    if (i + 1 < chain.n) chain.row.push_back(i + 1);
    chain.column_start.push_back(static_cast<int>(chain.row.size()));
  }
  const sparse::EliminationOrder order = sparse::FindEliminationOrder(chain, 2 * chain.n);
  EXPECT_FALSE(order.dissected);
  EXPECT_NEAR(order.block_operations, 2.0 * chain.n, 0.01 * chain.n);
  EXPECT_DOUBLE_EQ(order.operations(2 * chain.n), 8.0 * order.block_operations);
}

TEST(EliminationOrder, NothingHasAnEmptyOne) {
  const sparse::EliminationOrder order = sparse::FindEliminationOrder({0, {0}, {}, {}}, 0);
  EXPECT_TRUE(order.position.empty());
  EXPECT_EQ(order.operations(0), 0.0);
}

}  // namespace dn::solvers_test
