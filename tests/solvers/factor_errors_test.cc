#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace dn::solvers_test {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Returns a network of n priors on numbers; prior number `bad` throws above 0.5.
Network Throwing(int n, int bad) {
  Network net;
  for (int i = 0; i < n; ++i) {
    const auto x = net.AddScalar(std::to_string(i), 0.0);
    const auto prior = [throws = i == bad](const auto& v) {
      if (throws && v > 0.5) throw std::domain_error("beyond the table");
      return v - 1.0;
    };
    net.Add(prior, Noise<1>::Sigma(1.0), x);
  }
  return net;
}

TEST(Solve, PassesOnWhatAFactorThrows) {
  for (const int threads : {1, 2, 8}) {
    SCOPED_TRACE("threads " + std::to_string(threads));
    Network net = Throwing(500, 321);
    EXPECT_THAT(
        [&] { (void)Solve(net, {.threads = threads}); },
        ThrowsMessage<InvalidInput>(HasSubstr("factor 321 on '321' throws: beyond the table")));
    net.RemoveFactor(321);
    EXPECT_TRUE(Solve(net, {.threads = threads}).converged);
    EXPECT_NEAR(net.Value(Block<Scalar>{7}), 1.0, 1e-9);
  }
}

TEST(Marginals, PassOnWhatAFactorThrows) {
  Network net = Throwing(50, 7);
  net.SetValue(Block<Scalar>{7}, 0.9);
  for (const int threads : {1, 2}) {
    EXPECT_THAT([&] { Marginals(net, {.threads = threads}); },
                ThrowsMessage<InvalidInput>(HasSubstr("factor 7 on '7' throws")));
    EXPECT_THAT([&] { EvaluateCost(net, threads); },
                ThrowsMessage<InvalidInput>(HasSubstr("factor 7 on '7' throws")));
  }
}

/// Has two residuals but writes only one.
struct HalfWritten : AutoFactor<HalfWritten, 2, Scalar> {
  template <class T>
  bool Residual(const T* x, T* r) const {
    r[0] = x[0];
    return true;
  }
};

/// Writes a Jacobian only for its first block.
class HalfDifferentiated final : public Factor<HalfDifferentiated, 1, Scalar, Scalar> {
 public:
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    r[0] = x[0][0] - x[1][0];
    Put<0>(x, J, Eigen::Matrix<double, 1, 1>(1.0));
    return true;
  }
};

TEST(Solve, NamesTheRowThatAFactorDoesNotWrite) {
  Network net;
  const auto x = net.AddScalar("x", 1.0);
  net.Add(HalfWritten{}, x);
  const SolveSummary summary = Solve(net);
  EXPECT_FALSE(summary.converged);
  EXPECT_THAT(summary.message,
              HasSubstr("factor 0 on 'x' does not write row 1 of its 2 residuals"));
  EXPECT_THAT([&] { Marginals{net}; }, ThrowsMessage<InvalidInput>(HasSubstr("row 1 of its 2")));
  EXPECT_THAT([&] { EvaluateCost(net); }, ThrowsMessage<InvalidInput>(HasSubstr("row 1 of its 2")));
}

TEST(Solve, NamesTheBlockWhoseJacobianAFactorDoesNotWrite) {
  Network net;
  const auto x = net.AddScalar("x", 1.0), y = net.AddScalar("y", 2.0);
  net.Add(HalfDifferentiated{}, x, y);
  EXPECT_THAT(Solve(net).message, HasSubstr("does not write its Jacobian of block 'y'"));
  EXPECT_THAT([&] { Marginals{net}; },
              ThrowsMessage<InvalidInput>(HasSubstr("its Jacobian of block 'y'")));
  net.Hold(y);
  EXPECT_TRUE(Solve(net).converged);
}

TEST(Solve, ReportsRedundancyAndSigma0) {
  Network net;
  const auto x = net.AddScalar("x", 0.0);
  for (const double z : {1.0, 2.0, 6.0}) {
    net.Add([z](const auto& v) { return v - z; }, Noise<1>::Sigma(2.0), x);
  }
  const SolveSummary summary = Solve(net);
  EXPECT_EQ(summary.adjusted.redundancy(), 2);
  EXPECT_NEAR(summary.adjusted.sigma0(), std::sqrt((4.0 + 1.0 + 9.0) / 4.0 / 2.0), 1e-12);
  EXPECT_NEAR(EvaluateCost(net).sigma0(), summary.adjusted.sigma0(), 1e-12);
  net.RemoveFactor(0);
  net.RemoveFactor(1);
  EXPECT_TRUE(std::isnan(Solve(net).adjusted.sigma0()));
}

}  // namespace dn::solvers_test
