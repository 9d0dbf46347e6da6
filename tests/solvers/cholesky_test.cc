#include <dn/network.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "solvers/pose_graph.h"
#include "sparse/sparse.h"

namespace dn::solvers_test {

constexpr int kSide = 8;
constexpr int kBlockSize = 3;

/// A cube of blocks, each connected to its neighbours; the last supernodes are several panels wide.
struct BlockCube {
  Network network;
  sparse::SymmetricCsc blocks;
  sparse::SymmetricCsc A;
  Eigen::MatrixXd dense;

  explicit BlockCube(unsigned seed) {
    blocks.n = kSide * kSide * kSide;
    for (int b = 0; b < blocks.n; ++b) {
      const auto x = network.AddVector<kBlockSize>("x" + std::to_string(b), {0.0, 0.0, 0.0});
      network.Add(testing::MakeVectorPrior<kBlockSize>(Eigen::Vector3d::Zero(), 1.0), x);
    }
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    dense = Eigen::MatrixXd::Zero(kBlockSize * blocks.n, kBlockSize * blocks.n);
    blocks.column_start.push_back(0);
    for (int c = 0; c < blocks.n; ++c) {
      for (const int r : Below(c)) {
        blocks.row.push_back(r);
        auto block = dense.block<kBlockSize, kBlockSize>(kBlockSize * r, kBlockSize * c);
        for (double& x : block.reshaped()) x = uniform(generator);
        if (r == c) block = (block * block.transpose()).eval() + 12.0 * Eigen::Matrix3d::Identity();
      }
      blocks.column_start.push_back(static_cast<int>(blocks.row.size()));
    }
    dense = Eigen::MatrixXd(dense.selfadjointView<Eigen::Lower>());
    TakeLowerTriangle();
  }

  /// Returns the block and its neighbours with larger indices.
  static std::vector<int> Below(int b) {
    std::vector<int> rows = {b};
    if (b % kSide + 1 < kSide) rows.push_back(b + 1);
    if (b / kSide % kSide + 1 < kSide) rows.push_back(b + kSide);
    if (b / (kSide * kSide) + 1 < kSide) rows.push_back(b + kSide * kSide);
    return rows;
  }

  void TakeLowerTriangle() {
    A.n = kBlockSize * blocks.n;
    A.column_start.push_back(0);
    for (int c = 0; c < A.n; ++c) {
      for (const int r : Below(c / kBlockSize)) {
        for (int i = kBlockSize * r; i < kBlockSize * (r + 1); ++i) {
          if (i < c) continue;
          A.row.push_back(i);
          A.value.push_back(dense(i, c));
        }
      }
      A.column_start.push_back(static_cast<int>(A.row.size()));
    }
  }
};

std::vector<double> CscValues(const sparse::Cholesky& cholesky) {
  return {cholesky.values(), cholesky.values() + cholesky.pattern().num_values};
}

TEST(Cholesky, AgreesWithDenseFactorisation) {
  const BlockCube cube(1);
  const UnknownLayout layout(cube.network);
  sparse::Cholesky cholesky(cube.A, cube.blocks, layout);
  ASSERT_TRUE(cholesky.Factorize(cube.A, 0.5));

  const Eigen::MatrixXd shifted = cube.dense + 0.5 * Eigen::MatrixXd::Identity(cube.A.n, cube.A.n);
  const Eigen::LLT<Eigen::MatrixXd> llt(shifted);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(cube.A.n, -1.0, 2.0);
  EXPECT_LT((cholesky.Solve(b) - llt.solve(b)).cwiseAbs().maxCoeff(), 1e-13);
  const Eigen::MatrixXd L = llt.matrixL();
  EXPECT_NEAR(cholesky.LogDeterminant(), 2.0 * L.diagonal().array().log().sum(), 1e-9);

  const sparse::SelectedInverse selected(cholesky, 2);
  const Eigen::MatrixXd inverse = llt.solve(Eigen::MatrixXd::Identity(cube.A.n, cube.A.n));
  const std::vector<int>& at = cholesky.permuted_index();
  int inside = 0;
  for (int c = 0; c < cube.A.n; ++c) {
    for (int r = c; r < cube.A.n; ++r) {
      const std::optional<double> Z = selected.At(at[AsSize(r)], at[AsSize(c)]);
      if (!Z) continue;
      ++inside;
      ASSERT_NEAR(*Z, inverse(r, c), 1e-13) << r << " " << c;
    }
  }
  EXPECT_GE(inside, static_cast<int>(cube.A.row.size()));
}

// Uses more right-hand sides than are solved together, so that some are rows of a larger array.
TEST(Cholesky, HalvesOfSolutionsMultiplyToTheWhole) {
  const BlockCube cube(3);
  sparse::Cholesky cholesky(cube.A, cube.blocks, UnknownLayout(cube.network));
  ASSERT_TRUE(cholesky.Factorize(cube.A));
  const Eigen::MatrixXd B = Eigen::MatrixXd::Random(cube.A.n, 37);
  const Eigen::MatrixXd whole = B.transpose() * cholesky.Solve(B);
  for (const int threads : {1, 2, 5}) {
    Eigen::MatrixXd W(B.cols(), B.rows());
    for (int i = 0; i < cube.A.n; ++i) {
      W.col(cholesky.permuted_index()[AsSize(i)]) = B.row(i).transpose();
    }
    cholesky.SolveForward(threads, W);
    EXPECT_LT((W * W.transpose() - whole).norm(), 1e-12 * whole.norm());
  }
}

TEST(Cholesky, NumbersDoNotDependOnThreads) {
  const BlockCube cube(2);
  const UnknownLayout layout(cube.network);
  sparse::Cholesky one(cube.A, cube.blocks, layout);
  ASSERT_TRUE(one.Factorize(cube.A));
  const sparse::SelectedInverse inverse_of_one(one, 1);
  for (const int threads : {2, 5}) {
    sparse::Cholesky several(one);
    ASSERT_TRUE(several.Factorize(cube.A));
    EXPECT_EQ(CscValues(several), CscValues(one)) << threads;
    const sparse::SelectedInverse inverse(several, threads);
    for (int c = 0; c < cube.A.n; ++c) ASSERT_EQ(inverse.At(c, c), inverse_of_one.At(c, c)) << c;
  }
}

TEST(Cholesky, SaysWhereAMatrixIsNotPositiveDefiniteAndGoesOn) {
  const BlockCube cube(3);
  const UnknownLayout layout(cube.network);
  sparse::Cholesky cholesky(cube.A, cube.blocks, layout);
  EXPECT_FALSE(cholesky.Factorize(cube.A, -20.0));
  sparse::SymmetricCsc last_negative = cube.A;
  last_negative.value.back() = -1.0;
  EXPECT_FALSE(cholesky.Factorize(last_negative));
  sparse::SymmetricCsc undefined = cube.A;
  undefined.value[undefined.value.size() / 2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(cholesky.Factorize(undefined));
  EXPECT_TRUE(cholesky.Factorize(cube.A));
}

}  // namespace dn::solvers_test
