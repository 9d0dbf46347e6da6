#include <dn/builder/process_chain.h>
#include <dn/error.h>
#include <dn/solvers/marginals.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "testing/second_order.h"

namespace dn::builder_test {

using Type = BiasProcess::Type;

ProcessChain AddTo(Network* net, const BiasProcess& process,
                   const std::vector<ConstantInterval>& intervals, const ProcessModel& model = {}) {
  const FactorGroup group{"steps", {}, {}, FactorGroup::Kind::kProcess};
  const FactorGroup prior{"prior", {}, {}, FactorGroup::Kind::kPrior};
  return AddProcessChain(process, intervals, {"c", "error", {}, "m", 1.0, group, prior},
                         Eigen::Vector3d::Zero(), net, model);
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

// A model of the user's replaces prior and transitions: the blocks then have the covariance of a
// second-order process, whatever first-order process the chain states.
TEST(ProcessChain, AModelReplacesTheProcess) {
  constexpr double kSigma = 0.02, kOmega = 0.05;
  Network net;
  const ProcessChain chain =
      AddTo(&net, {Type::kGaussMarkov, 1.0, 1.0},
            IntervalsOverEpochs({0.0, 1.0, 2.0, 3.0, 60.0, 61.0, 100.0}, 2.0),
            [](const ProcessChain& own, Network* to) {
              testing::AddSecondOrder(own, kSigma, kOmega, to);
              return true;
            });
  const Marginals marginals(net);
  for (std::size_t i = 0; i < chain.blocks.size(); ++i) {
    for (std::size_t k = 0; k < chain.blocks.size(); ++k) {
      const double angle = kOmega * std::abs(chain.t_mid_s[i] - chain.t_mid_s[k]);
      const Eigen::Matrix3d C = marginals.Covariance(chain.blocks[i], chain.blocks[k]);
      const double expected = kSigma * kSigma * (1.0 + angle) * std::exp(-angle);
      EXPECT_LE((C - expected * Eigen::Matrix3d::Identity()).norm(), 1e-9 * kSigma * kSigma);
    }
  }
}

// Factors that the model does not tag get the groups and times of the chain, so that they do not
// count as measurements. A tag of its own stays.
TEST(ProcessChain, FactorsOfAModelGetTheGroupsOfTheChain) {
  Network net;
  const std::vector<ConstantInterval> intervals = IntervalsOverEpochs({0.0, 10.0, 20.0}, 1.0);
  AddTo(&net, {Type::kGaussMarkov, 1.0, 100.0}, intervals,
        [](const ProcessChain& chain, Network* to) {
          testing::AddSecondOrder(chain, 1.0, 0.01, to);
          const FactorId own = to->Add([](const auto& x) { return x.eval(); }, Noise<3>::Sigma(1e3),
                                       chain.blocks.back());
          to->Tag(own, "mine", 20.0);
          return true;
        });
  ASSERT_EQ(net.num_factors(), 4);
  const char* names[] = {"prior", "steps", "steps", "mine"};
  const double times_s[] = {0.0, 0.0, 10.0, 20.0};
  for (FactorId id = 0; id < net.num_factors(); ++id) {
    EXPECT_EQ(net.group(id).name, names[id]);
    EXPECT_EQ(net.factor(id).t_s, times_s[id]);
  }
  EXPECT_EQ(net.group(0).kind, FactorGroup::Kind::kPrior);
  EXPECT_EQ(net.group(1).kind, FactorGroup::Kind::kProcess);
}

TEST(ProcessChain, AModelCanKeepTheProcess) {
  const std::vector<ConstantInterval> intervals = IntervalsOverEpochs({0.0, 10.0, 20.0}, 1.0);
  const BiasProcess process{Type::kGaussMarkov, 1.0, 100.0};
  Network plain, kept;
  AddTo(&plain, process, intervals);
  AddTo(&kept, process, intervals, [](const ProcessChain&, Network*) { return false; });
  EXPECT_EQ(kept.num_factors(), plain.num_factors());
}

TEST(ProcessChain, AModelThatAddsFactorsMustReplaceTheProcess) {
  Network net;
  const auto both = [](const ProcessChain& chain, Network* to) {
    to->Add([](const auto& x) { return x.eval(); }, Noise<3>::Sigma(1.0), chain.blocks.front());
    return false;
  };
  try {
    AddTo(&net, {Type::kGaussMarkov, 1.0, 100.0}, IntervalsOverEpochs({0.0, 10.0}, 1.0), both);
    FAIL() << "no error";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("process model of 'c'"), std::string::npos);
  }
}

}  // namespace dn::builder_test
