#include <ceres/covariance.h>
#include <dn/ceres.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "solvers/pose_graph.h"

namespace dn::solvers_test {

using testing::MakePoseGraph;
using testing::MakeVectorPrior;
using testing::PoseGraph;

// Relative to the two standard deviations. The condition number of the scaled matrix is about 1e5.
constexpr double kMarginalsTolerance = 1e-9;

/// The dense covariance of all blocks that are not constant, and the offset of each block in it.
struct DenseCovariance {
  Eigen::MatrixXd C;
  std::vector<int> offset;
  const Network& network;

  explicit DenseCovariance(const Network& net) : network(net) {
    int n = 0;
    for (BlockId b = 0; b < net.num_blocks(); ++b) {
      offset.push_back(net.block(b).held ? -1 : n);
      if (!net.block(b).held) n += net.block(b).kind.tangent_size;
    }
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(n, n);
    for (FactorId id = 0; id < net.num_factors(); ++id) {
      if (net.factor(id).active) AddFactor(id, &N);
    }
    const Eigen::VectorXd scale = N.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = scale.asDiagonal() * N * scale.asDiagonal();
    C = scale.asDiagonal() * scaled.inverse() * scale.asDiagonal();
  }

  void AddFactor(FactorId id, Eigen::MatrixXd* N) const {
    const FactorRecord& record = network.factor(id);
    Eigen::VectorXd r;
    std::vector<Eigen::MatrixXd> J;
    ASSERT_TRUE(network.EvaluateFactor(id, &r, &J));
    const double s = r.squaredNorm(), w = record.loss.width;
    double weight = 1.0;
    if (record.loss.type == Loss::Type::kHuber && s > w * w) weight = w / std::sqrt(s);
    if (record.loss.type == Loss::Type::kCauchy) weight = 1.0 / (1.0 + s / (w * w));
    for (std::size_t a = 0; a < J.size(); ++a) {
      for (std::size_t b = 0; b < J.size(); ++b) {
        const int row = offset[static_cast<std::size_t>(record.blocks[a])];
        const int column = offset[static_cast<std::size_t>(record.blocks[b])];
        if (row < 0 || column < 0) continue;
        N->block(row, column, J[a].cols(), J[b].cols()) += weight * J[a].transpose() * J[b];
      }
    }
  }

  Eigen::MatrixXd Block(BlockId a, BlockId b) const {
    const int rows = network.block(a).kind.tangent_size, cols = network.block(b).kind.tangent_size;
    const int row = offset[static_cast<std::size_t>(a)],
              column = offset[static_cast<std::size_t>(b)];
    if (row < 0 || column < 0) return Eigen::MatrixXd::Zero(rows, cols);
    return C.block(row, column, rows, cols);
  }

  /// Returns the largest difference of X from block (a, b), in units of the standard deviations.
  double Difference(const Eigen::MatrixXd& X, BlockId a, BlockId b) const {
    const Eigen::MatrixXd D = X - Block(a, b);
    if (Block(a, a).isZero(0.0) || Block(b, b).isZero(0.0)) return D.cwiseAbs().maxCoeff();
    const Eigen::VectorXd sa = Block(a, a).diagonal().cwiseSqrt(),
                          sb = Block(b, b).diagonal().cwiseSqrt();
    return (sa.cwiseInverse().asDiagonal() * D * sb.cwiseInverse().asDiagonal())
        .cwiseAbs()
        .maxCoeff();
  }
};

/// Checks the blocks of each active factor together, and all blocks, which are not within the
/// pattern.
void ExpectJointBlocksAgree(const Network& network, const DenseCovariance& dense,
                            const Marginals& selected) {
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    if (!network.factor(id).active) continue;
    const std::vector<BlockId>& blocks = network.factor(id).blocks;
    const auto joint = selected.JointSelectedCovariance(blocks);
    ASSERT_TRUE(joint);
    Eigen::Index row = 0;
    for (const BlockId a : blocks) {
      const int rows = network.block(a).kind.tangent_size;
      Eigen::Index column = 0;
      for (const BlockId b : blocks) {
        const int columns = network.block(b).kind.tangent_size;
        EXPECT_LT(dense.Difference(joint->block(row, column, rows, columns), a, b),
                  kMarginalsTolerance);
        column += columns;
      }
      row += rows;
    }
    EXPECT_EQ(joint->rows(), row);
  }
  std::vector<BlockId> all;
  for (BlockId b = 0; b < network.num_blocks(); ++b) all.push_back(b);
  EXPECT_FALSE(selected.JointSelectedCovariance(all));
}

/// Checks columns, selected inverse and pairs of blocks against the dense inverse.
void ExpectAllBlocksAgree(const Network& network) {
  const DenseCovariance dense(network);
  Marginals columns(network), selected(network);
  selected.ComputeSelectedInverse();
  const auto boresight_columns = columns.SolveColumns({0, 1});
  int outside = 0;
  for (BlockId a = 0; a < network.num_blocks(); ++a) {
    EXPECT_LT(dense.Difference(columns.Covariance(a), a, a), kMarginalsTolerance);
    EXPECT_LT(dense.Difference(selected.DiagonalBlock(a), a, a), kMarginalsTolerance);
    EXPECT_LT(dense.Difference(selected.Covariance(a), a, a), kMarginalsTolerance);
    const Eigen::MatrixXd rows = boresight_columns.Rows(a);
    EXPECT_LT(dense.Difference(rows.leftCols(network.block(0).kind.tangent_size), a, 0),
              kMarginalsTolerance);
    EXPECT_LT(dense.Difference(rows.rightCols(network.block(1).kind.tangent_size), a, 1),
              kMarginalsTolerance);
    for (BlockId b = 0; b < a; ++b) {
      EXPECT_LT(dense.Difference(columns.Covariance(a, b), a, b), kMarginalsTolerance);
      EXPECT_LT(dense.Difference(selected.Covariance(b, a), b, a), kMarginalsTolerance);
      const auto block = selected.SelectedCovariance(a, b);
      if (block) {
        EXPECT_LT(dense.Difference(*block, a, b), kMarginalsTolerance);
      } else {
        ++outside;
      }
    }
  }
  EXPECT_GT(outside, 0);
  ExpectJointBlocksAgree(network, dense, selected);
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    for (const BlockId a : network.factor(id).blocks) {
      for (const BlockId b : network.factor(id).blocks) {
        EXPECT_TRUE(!network.factor(id).active || selected.SelectedCovariance(a, b).has_value());
      }
    }
  }
}

TEST(Marginals, AllWaysAgreeWithTheDenseInverseOnRandomGraphs) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    PoseGraph graph =
        MakePoseGraph(seed, {.nodes = 20 + 5 * static_cast<int>(seed), .loops = 10, .noise = 1.0});
    ASSERT_TRUE(Solve(graph.network).converged);
    ExpectAllBlocksAgree(graph.network);
  }
}

TEST(Marginals, HeldBlocksHaveZeroCovariance) {
  PoseGraph graph = MakePoseGraph(5, {.nodes = 30});
  graph.network.Hold(graph.q_mb[7]);
  graph.network.Hold(graph.p_mb[20]);
  graph.network.SetActive(graph.relative[3], false);
  graph.network.SetActive(graph.relative[35], false);
  ExpectAllBlocksAgree(graph.network);
  const Marginals marginals(graph.network);
  EXPECT_TRUE(marginals.Covariance(graph.q_mb[7]).isZero(0.0));
  EXPECT_TRUE(marginals.Covariance(graph.q_mb[7], graph.p_mb[1]).isZero(0.0));
  EXPECT_TRUE(marginals.SolveColumns({graph.q_mb[7].id}).Rows(graph.p_mb[1].id).isZero(0.0));
  EXPECT_THROW(marginals.ReducedNormal(graph.q_mb[7].id), InvalidInput);
}

void ExpectAgreesWithCeresCovariance(PoseGraph& graph) {
  Network& network = graph.network;
  NetworkProblem problem(network);
  std::vector<std::pair<const double*, const double*>> pairs;
  for (BlockId b = 0; b < network.num_blocks(); ++b)
    pairs.emplace_back(network.block(0).value.get(), network.block(b).value.get());
  ceres::Covariance::Options options;
  options.apply_loss_function = true;
  ceres::Covariance covariance(options);
  ASSERT_TRUE(covariance.Compute(pairs, &problem.problem()));

  const DenseCovariance dense(network);
  const Marginals marginals(network);
  for (BlockId b = 0; b < network.num_blocks(); ++b) {
    Eigen::Matrix3d C;
    covariance.GetCovarianceBlockInTangentSpace(pairs[static_cast<std::size_t>(b)].first,
                                                pairs[static_cast<std::size_t>(b)].second,
                                                C.data());
    EXPECT_LT(dense.Difference(C.transpose(), 0, b), kMarginalsTolerance);
    EXPECT_LT(dense.Difference(marginals.Covariance(0, b), 0, b), kMarginalsTolerance);
  }
}

TEST(Marginals, AgreeWithCeresCovariance) {
  PoseGraph graph = MakePoseGraph(21, {.noise = 1.0});
  ASSERT_TRUE(Solve(graph.network).converged);
  ExpectAgreesWithCeresCovariance(graph);
}

TEST(Marginals, WeighRobustFactorsAsCeres) {
  for (const Loss::Type type : {Loss::Type::kHuber, Loss::Type::kCauchy}) {
    PoseGraph graph = MakePoseGraph(22, {.noise = 3.0});
    for (const FactorId id : graph.relative) graph.network.SetLoss(id, {type, 1.5});
    // The comparison holds at any values, so convergence is not required.
    const SolveSummary summary = Solve(graph.network);
    ASSERT_LT(summary.final_cost, summary.initial_cost);
    ExpectAgreesWithCeresCovariance(graph);
    ExpectAllBlocksAgree(graph.network);
  }
}

// The covariance of a block with the left tangent is in the target frame of q.
TEST(Marginals, LeftAndRightTangentsDifferByTheRotation) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  Network net;
  const auto left = net.AddLeftRotation("left", q);
  const auto right = net.AddRotation("right", q);
  testing::RotationPrior<LeftRotation> on_left;
  testing::RotationPrior<Rotation> on_right;
  on_left.z = on_right.z = q * Exp(Eigen::Vector3d(0.1, 0.0, -0.2));
  net.Add(on_left, left);
  net.Add(on_right, right);
  const Marginals marginals(net);
  const Eigen::Matrix3d R = q.toRotationMatrix();
  EXPECT_LT((marginals.Covariance(left) - R * marginals.Covariance(right) * R.transpose()).norm(),
            1e-13);
}

TEST(Marginals, ReducedNormalInvertsTheCovariance) {
  PoseGraph graph = MakePoseGraph(6);
  const Marginals marginals(graph.network);
  const Eigen::Matrix3d product =
      marginals.ReducedNormal(graph.q_bs.id) * marginals.Covariance(graph.q_bs);
  EXPECT_LT((product - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT(
      (MarginalCovariance(graph.network, graph.q_bs) - marginals.Covariance(graph.q_bs)).norm(),
      1e-15);
}

/// r = (b - a) / sigma.
struct UnequalDifference : AutoFactor<UnequalDifference, 2, Vec<2>, Vec<2>> {
  template <class T>
  bool Residual(const T* a, const T* b, T* r) const {
    r[0] = (b[0] - a[0]) / 0.1;
    r[1] = (b[1] - a[1]) / 0.3;
    return true;
  }
};

TEST(Marginals, SigmaOfAScalarIsANumber) {
  Network net;
  const Block<Scalar> a = net.AddScalar("a", 1.0), b = net.AddScalar("b", 2.0);
  net.Add([](const auto& x) { return x - 1.0; }, Noise<1>::Sigma(0.3), a);
  net.Add([](const auto& x, const auto& y) { return y - x - 1.0; }, Noise<1>::Sigma(0.4), a, b);
  const double sigma = MarginalSigma(net, b);
  EXPECT_NEAR(sigma, 0.5, 1e-14);
  net.Hold(b);
  EXPECT_EQ(MarginalSigma(net, b), 0.0);
}

// In a chain of n differences from a constant end, the last sigma is sigma sqrt(n).
TEST(Marginals, VarianceGrowsAlongAChain) {
  Network net;
  std::vector<Block<Vec<2>>> x;
  for (int i = 0; i <= 9; ++i) {
    x.push_back(net.AddVector<2>("x/" + std::to_string(i), Eigen::Vector2d::Zero()));
    if (i > 0) net.Add(UnequalDifference{}, x[x.size() - 2], x.back());
  }
  net.Hold(x[0]);
  Marginals marginals(net);
  EXPECT_NEAR(marginals.Covariance(x[9])(0, 0), 9 * 0.01, 1e-13);
  EXPECT_NEAR(marginals.Covariance(x[9])(1, 1), 9 * 0.09, 1e-13);
  EXPECT_NEAR(marginals.Covariance(x[9], x[4])(0, 0), 4 * 0.01, 1e-13);
  EXPECT_NEAR((marginals.Sigma(x[9]) - Eigen::Vector2d(0.3, 0.9)).norm(), 0.0, 1e-13);
  EXPECT_EQ(marginals.num_parameters(), 18);
  EXPECT_GE(marginals.factor_nonzeros(), 18);
}

TEST(Marginals, ThreadsDoNotChangeTheResult) {
  PoseGraph graph = MakePoseGraph(9, {.noise = 1.0});
  const Eigen::Matrix3d one = Marginals(graph.network).Covariance(graph.q_bs);
  const Eigen::Matrix3d two = Marginals(graph.network, {.threads = 2}).Covariance(graph.q_bs);
  EXPECT_EQ(one, two);
}

TEST(Marginals, SurvivesTheNetworkAndItsOwnMove) {
  auto graph = std::make_unique<PoseGraph>(MakePoseGraph(4));
  Marginals first(graph->network);
  const Eigen::Matrix3d expected = first.Covariance(graph->q_bs);
  const Block<LeftRotation> q_bs = graph->q_bs;
  Marginals::Columns columns = first.SolveColumns({q_bs.id});
  const Marginals second = std::move(first);
  graph.reset();
  EXPECT_EQ(second.Covariance(q_bs), expected);
  EXPECT_LT((columns.Rows(q_bs.id) - expected).norm(), kMarginalsTolerance * expected.norm());
}

TEST(Marginals, RejectsWhatItCannotAnswer) {
  PoseGraph graph = MakePoseGraph(4);
  const auto unused = graph.network.AddVector<3>("unused", Eigen::Vector3d::Zero());
  Marginals marginals(graph.network);
  EXPECT_THROW(marginals.Covariance(unused), RankDeficient);
  EXPECT_THROW(marginals.Covariance(-1), InvalidInput);
  EXPECT_THROW(marginals.Covariance(graph.network.num_blocks()), InvalidInput);
  EXPECT_THROW(marginals.DiagonalBlock(graph.q_bs.id), InvalidInput);
  EXPECT_THROW((void)marginals.SelectedCovariance(0, 1), InvalidInput);
  EXPECT_THROW(Marginals(graph.network, {.threads = 0}), InvalidConfig);
  EXPECT_THROW(Marginals(graph.network, {.null_tolerance = 0.0}), InvalidConfig);
}

TEST(Marginals, OfHeldBlocksOnly) {
  Network net;
  const auto x = net.AddVector<3>("x", Eigen::Vector3d::Zero());
  net.Add(MakeVectorPrior<3>(Eigen::Vector3d::Zero(), 1.0), x);
  net.Hold(x);
  Marginals marginals(net);
  marginals.ComputeSelectedInverse();
  EXPECT_EQ(marginals.num_parameters(), 0);
  EXPECT_TRUE(marginals.Covariance(x).isZero(0.0));
  EXPECT_TRUE(marginals.DiagonalBlock(x.id).isZero(0.0));
}

}  // namespace dn::solvers_test
