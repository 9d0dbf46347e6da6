#include <dn/error.h>
#include <dn/solvers/fit_check.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "solvers/one_by_one.h"
#include "solvers/pose_graph.h"

namespace dn::solvers_test {

using testing::MakeVectorPrior;
using testing::OneByOne;

const FactorGroup kThermometer{"thermometer", {{"inside"}}};

Marginals WithSelectedInverse(const Network& net) {
  Marginals marginals(net);
  marginals.ComputeSelectedInverse();
  return marginals;
}

// One unknown is measured four times with sigma 1 as 1, 1, 1 and 5. The mean is 2, the residuals
// are -1, -1, -1 and 3 (with opposite signs), and chi2 = 12 with redundancy 3. Each row has the
// redundancy number 3/4, so w = 3 / sqrt(3/4) and the minimal detectable bias is 4.13 / sqrt(3/4)
// sigmas.
TEST(CheckFit, OfAMean) {
  Network net;
  const auto x = net.AddVector<1>("x", OneByOne(2.0));
  FactorId last = -1;
  for (const double measured : {1.0, 1.0, 1.0, 5.0}) {
    last = net.Add(MakeVectorPrior<1>(OneByOne(measured), 1.0), x);
    net.Tag(last, kThermometer, 10.0 + measured);
  }
  const FitCheck check = CheckFit(WithSelectedInverse(net));
  EXPECT_NEAR(check.chi2, 12.0, 1e-12);
  EXPECT_EQ(check.redundancy, 3);
  EXPECT_NEAR(check.sigma0, 2.0, 1e-12);
  const double tail_of_12_with_3 =
      std::erfc(std::sqrt(6.0)) + std::sqrt(24.0 / std::numbers::pi) * std::exp(-6.0);
  EXPECT_NEAR(check.p_value, 2.0 * tail_of_12_with_3, 1e-12);

  ASSERT_EQ(check.channels.size(), 2U);
  const ChannelFit& channel = check.channels[0];
  EXPECT_EQ(channel.name, "thermometer");
  EXPECT_EQ(check.channels[1].name, "thermometer inside");
  EXPECT_EQ(channel.observations, 4);
  EXPECT_NEAR(channel.redundancy, 3.0, 1e-12);
  EXPECT_NEAR(channel.variance_ratio, 4.0, 1e-12);
  EXPECT_NEAR(channel.p_value, check.p_value, 1e-9) << "the channel contains all rows";
  EXPECT_NEAR(channel.minimal_detectable, (3.2905267 + 0.8416212) / std::sqrt(0.75), 1e-6);

  EXPECT_EQ(check.worst.row.factor, last);
  EXPECT_EQ(check.worst.row.channel, "thermometer");
  EXPECT_EQ(check.worst.row.axis, "inside");
  EXPECT_EQ(check.worst.row.t_s, 15.0);
  EXPECT_NEAR(std::abs(check.worst.standardised), 3.0 / std::sqrt(0.75), 1e-12);
  // The largest w^2 is 12: with four rows the Bonferroni p-value is 4 erfc(sqrt 6).
  EXPECT_NEAR(check.worst_p_value, 4.0 * std::erfc(std::sqrt(6.0)), 1e-12);
}

// One of two thermometers is three times as noisy as stated. Priors do not form a channel.
TEST(CheckFit, ConvictsTheGroupWhoseNoiseIsStatedWrong) {
  std::mt19937 rng(3);
  std::normal_distribution<double> normal;
  Network net;
  for (int k = 0; k < 150; ++k) {
    const auto x = net.AddVector<1>("x/" + std::to_string(k), OneByOne(0.0));
    const double truth = 100.0 * normal(rng);
    for (const bool bad : {false, true, false, true}) {
      const double measured = truth + (bad ? 3.0 : 1.0) * normal(rng);
      net.Tag(net.Add(MakeVectorPrior<1>(OneByOne(measured), 1.0), x), bad ? "bad" : "good", k);
    }
    const FactorId prior = net.Add(MakeVectorPrior<1>(OneByOne(0.0), 100.0), x);
    net.Tag(prior, {"prior", {}, {}, FactorGroup::Kind::kPrior}, k);
  }
  for (const bool weighted_right : {false, true}) {
    if (weighted_right) {
      for (FactorId id = 0; id < net.num_factors(); ++id) {
        if (net.group(id).name != "bad") continue;
        Eigen::VectorXd r;
        ASSERT_TRUE(net.EvaluateFactor(id, &r));
        const double z = net.Value(Block<Vec<1>>{net.factor(id).blocks[0]})[0] - r[0];
        net.ReplaceFactor(
            id, std::make_shared<testing::VectorPrior<1>>(MakeVectorPrior<1>(OneByOne(z), 3.0)));
      }
    }
    ASSERT_TRUE(Solve(net).converged);
    const FitCheck check = CheckFit(WithSelectedInverse(net));
    ASSERT_EQ(check.channels.size(), 4U);
    const ChannelFit& good = check.channels[0];
    const ChannelFit& bad = check.channels[2];
    EXPECT_EQ(good.name, "good");
    EXPECT_EQ(bad.name, "bad");
    if (weighted_right) {
      EXPECT_GT(check.p_value, 1e-3);
      EXPECT_GT(good.p_value, 1e-3);
      EXPECT_GT(bad.p_value, 1e-3);
      EXPECT_NEAR(bad.variance_ratio, 1.0, 0.3);
    } else {
      EXPECT_LT(check.p_value, 1e-12);
      EXPECT_LT(bad.p_value, 1e-6);
      EXPECT_GT(bad.variance_ratio, 3.0);
    }
  }
}

TEST(OutlierTest, RefusesProbabilitiesThatAreNone) {
  EXPECT_NEAR(OutlierTest{}.NonCentrality(), 4.132148, 1e-6) << "square root of Baarda's 17.07";
  EXPECT_TRUE(std::isinf(OutlierTest{}.MinimalDetectableBias(0.0)));
  EXPECT_THROW((OutlierTest{.alpha = 0.0}.NonCentrality()), InvalidConfig);
  EXPECT_THROW((OutlierTest{.alpha = 0.001, .power = 1.0}.NonCentrality()), InvalidConfig);
}

// The sum of squares of n rows after fitting one mean has the exact mean n - 1 and variance 2 (n -
// 1). The sum of the rows is zero, because the mean absorbs their common part.
TEST(ResidualForm, MomentsOfAMean) {
  Network net;
  const auto x = net.AddVector<1>("x", OneByOne(0.0));
  for (int k = 0; k < 5; ++k) {
    net.Tag(net.Add(MakeVectorPrior<1>(OneByOne(0.0), 1.0), x), kThermometer, k);
  }
  const Marginals marginals(net);
  std::vector<ResidualForm> forms = ChannelForms(marginals.linearized());
  forms[1].label.assign(5, 0);
  forms[1].labels = 1;
  const std::vector<FormMoments> moments = ComputeFormMoments(marginals, forms);
  EXPECT_NEAR(moments[0].mean, 4.0, 1e-12);
  EXPECT_NEAR(moments[0].variance, 8.0, 1e-12);
  EXPECT_NEAR(moments[0].Dof(), 4.0, 1e-12);
  EXPECT_NEAR(moments[1].mean, 0.0, 1e-12);
}

// For many rows the moments come from samples, and report the number of samples.
TEST(ResidualForm, MomentsOfManyRowsAreThoseOfSamples) {
  Network net;
  for (int k = 0; k < 250; ++k) {
    const auto x = net.AddVector<1>("x/" + std::to_string(k), OneByOne(0.0));
    for (int i = 0; i < 2; ++i) {
      net.Tag(net.Add(MakeVectorPrior<1>(OneByOne(0.0), 1.0), x), kThermometer, k);
    }
  }
  const Marginals marginals(net);
  const FormMoments moments =
      ComputeFormMoments(marginals, ChannelForms(marginals.linearized())).front();
  EXPECT_GT(moments.samples, 0);
  EXPECT_NEAR(moments.mean, 250.0, 4.0 * std::sqrt(500.0 / moments.samples));
  EXPECT_LT(moments.Dof(), 2.0 * moments.mean * moments.mean / moments.variance)
      << "must be conservative";
}

}  // namespace dn::solvers_test
