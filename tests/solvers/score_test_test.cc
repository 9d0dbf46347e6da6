#include <dn/error.h>
#include <dn/solvers/score_test.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "solvers/pose_graph.h"
#include "solvers/step_factor.h"

namespace dn::solvers_test {

using testing::MakeVectorPrior;
using testing::Step;

/// r = (x + offset - z) / sigma: a position with an offset from another block.
struct ShiftedPosition : AutoFactor<ShiftedPosition, 3, Vec<3>, Vec<3>> {
  Eigen::Vector3d z;
  double sigma = 1.0;
  template <class T>
  bool Residual(const T* x, const T* offset, T* r) const {
    for (int i = 0; i < 3; ++i) r[i] = (x[i] + offset[i] - z[i]) / sigma;
    return true;
  }
};

/// A chain of noisy steps in which the positions of nodes 20 to 29 share an offset.
struct OffsetChain {
  Network net;
  Block<Vec<3>> offset;
  std::vector<FactorId> positions;

  OffsetChain(unsigned seed, const Eigen::Vector3d& true_offset) {
    std::mt19937 rng(seed);
    std::normal_distribution<double> normal;
    const auto noise = [&](double sigma) {
      const double x = normal(rng), y = normal(rng), z = normal(rng);
      return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
    };
    offset = net.AddVector<3>("offset", Eigen::Vector3d::Zero());
    Block<Vec<3>> before;
    for (int k = 0; k < 50; ++k) {
      const auto x = net.AddVector<3>("x/" + std::to_string(k), Eigen::Vector3d::Zero());
      ShiftedPosition position;
      position.z = noise(0.5) + (shifted(k) ? true_offset : Eigen::Vector3d::Zero().eval());
      position.sigma = 0.5;
      if (shifted(k)) {
        positions.push_back(net.Add(position, x, offset));
      } else {
        net.Add(MakeVectorPrior<3>(position.z, 0.5), x);
      }
      Step step;
      step.z = noise(0.2);
      step.sigma = 0.2;
      if (k > 0) net.Add(step, before, x);
      before = x;
    }
    net.Hold(offset);
  }

  static bool shifted(int k) { return k >= 20 && k < 30; }

  EffectModel Offset() const {
    EffectModel effect;
    for (const FactorId id : positions) {
      effect.push_back({id, Eigen::MatrixXd(Eigen::Matrix3d::Identity() / 0.5)});
    }
    return effect;
  }

  double SolveCost() {
    SolveOptions options;
    options.function_tolerance = 1e-16;
    const SolveSummary summary = Solve(net, options);
    EXPECT_TRUE(summary.converged);
    return summary.final_cost;
  }

  ScoreTest Test() { return TestEffects(Marginals(net), {Offset()}).front(); }
};

// The problem is linear, so the test must predict the adjustment with the effect exactly.
TEST(ScoreTest, EqualsTheAdjustmentWithTheEffect) {
  OffsetChain chain(1, {0.7, -0.2, 0.4});
  const double cost_without = chain.SolveCost();
  const ScoreTest test = chain.Test();
  chain.net.Hold(chain.offset, false);
  const double cost_with = chain.SolveCost();
  EXPECT_EQ(test.dof, 3);
  EXPECT_NEAR(test.statistic, 2.0 * (cost_without - cost_with), 1e-6);
  EXPECT_LT((test.estimate - chain.net.Value(chain.offset)).norm(), 1e-6);
  EXPECT_LT((test.covariance - Marginals(chain.net).Covariance(chain.offset)).norm(), 1e-9);
}

TEST(ScoreTest, IsChiSquareWithoutTheEffect) {
  double sum = 0.0;
  constexpr int kSeeds = 200;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    OffsetChain chain(seed, Eigen::Vector3d::Zero());
    chain.SolveCost();
    sum += chain.Test().statistic;
  }
  const double dof = 3.0 * kSeeds;
  EXPECT_NEAR(sum / dof, 1.0, 4.0 * std::sqrt(2.0 / dof));
}

TEST(ScoreTest, ManyEffectsAtOnceAreTestedEachByItself) {
  OffsetChain chain(2, {0.3, 0.0, 0.0});
  chain.SolveCost();
  const Marginals marginals(chain.net);
  const std::vector<EffectModel> effects(40, chain.Offset());
  const std::vector<ScoreTest> tests = TestEffects(marginals, effects);
  ASSERT_EQ(tests.size(), effects.size());
  for (const ScoreTest& test : tests) {
    EXPECT_NEAR(test.statistic, tests.front().statistic, 1e-9 * tests.front().statistic);
  }
}

// The offset of every position is a shift of the whole chain, so it is not estimable.
TEST(ScoreTest, DropsWhatTheUnknownsAbsorb) {
  Network net;
  const auto x = net.AddVector<3>("x", Eigen::Vector3d::Zero());
  const FactorId id = net.Add(MakeVectorPrior<3>(Eigen::Vector3d(1.0, 2.0, 3.0), 1.0), x);
  const EffectModel shift{{id, Eigen::MatrixXd::Identity(3, 3)}};
  const ScoreTest test = TestEffects(Marginals(net), {shift}).front();
  EXPECT_EQ(test.dof, 0);
  EXPECT_EQ(test.statistic, 0.0);
}

/// Splits the offset into its first component and the other two, and adds a slope over the same
/// positions.
std::vector<EffectModel> Parts(const OffsetChain& chain) {
  std::vector<EffectModel> parts(3);
  double k = 0.0;
  for (const EffectPart& part : chain.Offset()) {
    parts[0].push_back({part.factor, part.L.leftCols(1)});
    parts[1].push_back({part.factor, part.L.rightCols(2)});
    parts[2].push_back({part.factor, (k - 4.5) * part.L.leftCols(1)});
    k += 1.0;
  }
  return parts;
}

TEST(JointScore, TogetherIsTheEffectAsAWhole) {
  OffsetChain chain(3, {0.5, 0.1, -0.3});
  chain.SolveCost();
  const JointScore score = ScoreEffects(Marginals(chain.net), Parts(chain), {});
  const ScoreTest whole = chain.Test();
  const ScoreTest together = TestJointly(score, {0, 1, 2});
  EXPECT_NEAR(together.statistic, whole.statistic, 1e-9);
  EXPECT_LT((together.estimate - whole.estimate).norm(), 1e-9);
  EXPECT_EQ(score.Components(1), (std::vector<Eigen::Index>{1, 2}));
}

// Conditioning on an effect must equal having it among the unknowns.
TEST(JointScore, GivenAnEffectIsTheTestBesideIt) {
  OffsetChain chain(4, {0.5, 0.1, -0.3});
  chain.SolveCost();
  const auto x25 = Block<Vec<3>>{chain.net.Find("x/25")};
  const JointScore score = ScoreEffects(Marginals(chain.net), Parts(chain), {x25.id});
  const JointScore given = ConditionOn(score, Eigen::MatrixXd::Identity(score.s.size(), 3));
  chain.net.Hold(chain.offset, false);
  chain.SolveCost();
  const JointScore beside = ScoreEffects(Marginals(chain.net), Parts(chain), {x25.id});
  const ScoreTest a = TestJointly(given, {3}), b = TestJointly(beside, {3});
  EXPECT_NEAR(a.statistic, b.statistic, 1e-6);
  EXPECT_NEAR(a.estimate[0], b.estimate[0], 1e-7);
  EXPECT_LT((given.shift.col(3) - beside.shift.col(3)).norm(), 1e-9);
  EXPECT_EQ(TestJointly(given, {0}).dof, 0) << "the component is already among the unknowns";
}

// The shift predicts how far the unknowns move once the effect is estimated.
TEST(JointScore, ShiftIsWhatTheEffectDidToTheUnknowns) {
  OffsetChain chain(5, {0.7, -0.2, 0.4});
  chain.SolveCost();
  const auto x25 = Block<Vec<3>>{chain.net.Find("x/25")};
  const JointScore score = ScoreEffects(Marginals(chain.net), {chain.Offset()}, {x25.id});
  const ScoreTest test = TestJointly(score, {0, 1, 2});
  const Eigen::Vector3d without = chain.net.Value(x25);
  chain.net.Hold(chain.offset, false);
  chain.SolveCost();
  const Eigen::Vector3d moved = without - chain.net.Value(x25);
  EXPECT_LT((score.shift * test.estimate - moved).norm(), 1e-7);
}

// A step has zero derivatives before it; those factors must be treated as absent.
TEST(JointScore, PartsOfZerosAreAsNone) {
  OffsetChain chain(6, {0.5, 0.1, -0.3});
  chain.SolveCost();
  EffectModel late = chain.Offset(), later_only = late;
  for (std::size_t k = 0; k < 5; ++k) late[k].L.setZero();
  later_only.erase(later_only.begin(), later_only.begin() + 5);
  const auto x25 = Block<Vec<3>>{chain.net.Find("x/25")};
  const Marginals marginals(chain.net);
  const JointScore with = ScoreEffects(marginals, {late}, {x25.id});
  const JointScore without = ScoreEffects(marginals, {later_only}, {x25.id});
  EXPECT_LT((with.s - without.s).norm(), 1e-12);
  EXPECT_LT((with.A - without.A).norm(), 1e-12 * with.A.norm());
  EXPECT_LT((with.shift - without.shift).norm(), 1e-12);
}

TEST(ScoreTest, SaysNothingOfAnEffectWithoutAnActiveFactor) {
  OffsetChain chain(1, Eigen::Vector3d::Zero());
  const EffectModel effect = chain.Offset();
  for (const EffectPart& part : effect) chain.net.SetActive(part.factor, false);
  const Marginals marginals(chain.net);
  EXPECT_EQ(TestEffects(marginals, {effect}).front().dof, 0);
  const BlockId x25 = chain.net.Find("x/25");
  const JointScore score = ScoreEffects(marginals, {effect}, {x25});
  EXPECT_EQ(TestJointly(score, {0, 1, 2}).dof, 0);
  EXPECT_EQ(score.shift, Eigen::MatrixXd::Zero(3, 3));
}

TEST(ScoreTest, SizesThatDoNotFitAreNamed) {
  OffsetChain chain(1, Eigen::Vector3d::Zero());
  const Marginals marginals(chain.net);
  EffectModel effect = chain.Offset();
  effect[3].L = Eigen::MatrixXd::Identity(3, 2);
  EXPECT_THROW(TestEffects(marginals, {effect}), InvalidInput);
  EXPECT_THROW(marginals.Solve({{chain.offset.id, Eigen::MatrixXd::Zero(3, 1)}}), InvalidInput)
      << "held";
}

}  // namespace dn::solvers_test
