#include <dn/builder/process_chain.h>
#include <dn/solvers/marginals.h>
#include <gtest/gtest.h>

#include <cmath>

namespace dn::builder_test {

using Type = BiasProcess::Type;

ProcessChain AddTo(Network* net, const BiasProcess& process,
                   const std::vector<ConstantInterval>& intervals) {
  const FactorGroup group{"steps", {}, {}, FactorGroup::Kind::kProcess};
  const FactorGroup prior{"prior", {}, {}, FactorGroup::Kind::kPrior};
  return AddProcessChain(process, intervals, {"c", "error", {}, "m", 1.0, group, prior},
                         Eigen::Vector3d::Zero(), net);
}

// An interval of 3 s contains three epochs of 1 Hz, and intervals do not span the outage. If the
// length is shorter than an epoch, each epoch has its own interval.
TEST(ProcessChain, IntervalsHoldEpochs) {
  const std::vector<double> t_s{0.0, 1.0, 2.0, 3.0, 4.0, 60.0, 61.0, 62.0, 63.0};
  const std::vector<ConstantInterval> three = IntervalsOverEpochs(t_s, 3.0);
  ASSERT_EQ(three.size(), 4U);
  const std::vector<double> begin{0.0, 3.0, 60.0, 63.0}, middle{1.0, 3.5, 61.0, 63.0};
  for (std::size_t k = 0; k < three.size(); ++k) {
    EXPECT_EQ(three[k].t_begin_s, begin[k]);
    EXPECT_EQ(three[k].t_mid_s, middle[k]);
  }
  const std::vector<ConstantInterval> each = IntervalsOverEpochs(t_s, 0.01);
  ASSERT_EQ(each.size(), t_s.size());
  for (std::size_t k = 0; k < each.size(); ++k) EXPECT_EQ(each[k].t_mid_s, t_s[k]);
}

// Without measurements the states of a Gauss-Markov process have its stationary covariance sigma^2
// exp(-dt / tau), whatever the intervals are.
TEST(ProcessChain, HasTheCovarianceOfItsProcess) {
  constexpr double kSigma = 0.02, kTauS = 40.0;
  Network net;
  const ProcessChain chain =
      AddTo(&net, {Type::kGaussMarkov, kSigma, kTauS},
            IntervalsOverEpochs({0.0, 1.0, 2.0, 3.0, 60.0, 61.0, 100.0}, 2.0));
  const Marginals marginals(net);
  for (std::size_t i = 0; i < chain.blocks.size(); ++i) {
    for (std::size_t k = 0; k < chain.blocks.size(); ++k) {
      const double dt_s = std::abs(chain.t_mid_s[i] - chain.t_mid_s[k]);
      const Eigen::Matrix3d C = marginals.Covariance(chain.blocks[i], chain.blocks[k]);
      const double expected = kSigma * kSigma * std::exp(-dt_s / kTauS);
      EXPECT_LE((C - expected * Eigen::Matrix3d::Identity()).norm(), 1e-9 * kSigma * kSigma);
    }
  }
}

TEST(ProcessChain, FindsTheBlockOfAnEpoch) {
  Network net;
  const ProcessChain chain =
      AddTo(&net, {Type::kRandomWalk, 1.0, 0.0}, IntervalsOverNodes({0.0, 2.0, 4.0, 6.0}, 2.0));
  ASSERT_EQ(chain.blocks.size(), 3U);
  EXPECT_EQ(chain.At(1.999).id, chain.blocks[0].id);
  EXPECT_EQ(chain.At(2.0).id, chain.blocks[1].id);
  EXPECT_EQ(chain.At(100.0).id, chain.blocks[2].id);
  EXPECT_EQ(net.Find("c/2"), chain.blocks[2].id);
}

}  // namespace dn::builder_test
