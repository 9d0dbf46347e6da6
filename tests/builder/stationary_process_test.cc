#include <dn/builder/stationary_process.h>
#include <dn/error.h>
#include <dn/solvers/marginals.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

namespace dn::builder_test {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Adds a chain with uneven intervals that has the process.
ProcessChain AddChain(const StationaryProcess& process, Network* net) {
  const auto intervals = IntervalsOverEpochs({0.0, 1.0, 2.0, 3.0, 60.0, 61.0, 100.0}, 2.0);
  return AddProcessChain({BiasProcess::Type::kGaussMarkov, 1.0, 1.0}, intervals, {"c"},
                         Eigen::Vector3d::Zero(), net, [&](const ProcessChain& chain, Network* to) {
                           AddStationaryProcess(process, chain, to);
                           return true;
                         });
}

// Without measurements the errors have the covariance (exp(F dt) P)_00, whatever the intervals are.
// The process of third order is a damped oscillation in which a slow process acts.
TEST(StationaryProcess, ErrorsHaveTheirCovariance) {
  StationaryProcess first, third;
  first.F = Eigen::MatrixXd::Constant(1, 1, -1.0 / 40.0);
  first.P = Eigen::MatrixXd::Constant(1, 1, 0.04);
  third.F = Eigen::Matrix3d{{0.0, 1.0, 0.0}, {-0.04, -0.1, 1.0}, {0.0, 0.0, -0.02}};
  // P is that of a process with noise at steps of 0.1 s, which divide all intervals.
  third.P = Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d step = (third.F * 0.1).exp();
  for (int k = 0; k < 20000; ++k) {
    third.P = step * third.P * step.transpose();
    third.P(2, 2) += 0.1;
  }
  for (const StationaryProcess& process :
       {first, StationaryProcess::SecondOrder(0.2, 0.05), third}) {
    SCOPED_TRACE(process.F.rows());
    Network net;
    const ProcessChain chain = AddChain(process, &net);
    const Marginals marginals(net);
    for (std::size_t i = 0; i < chain.blocks.size(); ++i) {
      for (std::size_t k = i; k < chain.blocks.size(); ++k) {
        const double dt_s = chain.t_mid_s[k] - chain.t_mid_s[i];
        const Eigen::Matrix3d C = marginals.Covariance(chain.blocks[k], chain.blocks[i]);
        const double expected = Eigen::MatrixXd((process.F * dt_s).exp() * process.P)(0, 0);
        EXPECT_LE((C - expected * Eigen::Matrix3d::Identity()).norm(), 1e-7 * process.P(0, 0));
      }
    }
  }
}

TEST(StationaryProcess, SecondOrderIsCriticallyDamped) {
  constexpr double kSigma = 0.2, kOmega = 0.05;
  Network net;
  const ProcessChain chain = AddChain(StationaryProcess::SecondOrder(kSigma, kOmega), &net);
  const double angle = kOmega * (chain.t_mid_s[2] - chain.t_mid_s[0]);
  EXPECT_NEAR(Marginals(net).Covariance(chain.blocks[2], chain.blocks[0])(1, 1),
              kSigma * kSigma * (1.0 + angle) * std::exp(-angle), 1e-9);
  EXPECT_THROW((void)StationaryProcess::SecondOrder(0.0, 1.0), InvalidInput);
  EXPECT_THROW((void)StationaryProcess::SecondOrder(1.0, -1.0), InvalidInput);
}

TEST(StationaryProcess, RejectsMatricesThatDoNotFit) {
  Network net;
  StationaryProcess process = StationaryProcess::SecondOrder(1.0, 0.1);
  process.P(1, 1) *= 100.0;  // not the stationary covariance of F
  EXPECT_THAT([&] { AddChain(process, &net); },
              ThrowsMessage<InvalidInput>(HasSubstr("process of 'c': the noise over ")));
  Network other;
  process.P = Eigen::Matrix3d::Identity();
  EXPECT_THAT([&] { AddChain(process, &other); },
              ThrowsMessage<InvalidInput>(HasSubstr("F is 2 x 2 and P is 3 x 3")));
}

}  // namespace dn::builder_test
