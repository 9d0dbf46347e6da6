#include "solvers/nist.h"

#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace dn::solvers_test {

using namespace testing;

// Number of certified digits that the default options must reach.
constexpr double kDigits = 6.0;
// Lanczos1 has no noise: its residuals, and therefore its standard deviations, come from rounding
// of the data to 13 digits.
constexpr double kDigitsOfRounding = 3.0;
// Parameters far below their own standard deviation have no significant digits: 1 +- 2e7 in
// Wampler5.
constexpr double kInSigma = 1e-6;

struct Fit {
  SolveSummary summary;
  Eigen::VectorXd value;
  Eigen::VectorXd sigma;  ///< scaled by the residuals
};

struct Problem {
  std::string name;
  std::function<Fit(const NistData&, const std::vector<double>& start)> fit;
  double sigma_digits = kDigits;
};

template <class Model, int kPredictors = 1>
Problem MakeProblem(const std::string& name, double sigma_digits = kDigits) {
  return {name,
          [](const NistData& data, const std::vector<double>& start) {
            Network net;
            const auto b = AddNist<Model, kPredictors>(data, start, &net);
            Fit fit;
            fit.summary = Solve(net);
            fit.value = net.Value(b);
            fit.sigma =
                fit.summary.adjusted.sigma0() * MarginalCovariance(net, b).diagonal().cwiseSqrt();
            return fit;
          },
          sigma_digits};
}

void ExpectCertified(const NistData& data, const Fit& fit, double sigma_digits) {
  EXPECT_TRUE(fit.summary.converged) << fit.summary.message;
  EXPECT_EQ(fit.summary.adjusted.redundancy(), data.observations() - data.parameters());
  for (std::size_t k = 0; k < data.certified.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double error = std::abs(fit.value[i] - data.certified[k]);
    EXPECT_TRUE(AgreeingDigits(fit.value[i], data.certified[k]) >= kDigits ||
                error <= kInSigma * data.sigma[k])
        << "parameter " << k << " is " << fit.value[i] << ", certified " << data.certified[k];
    EXPECT_GE(AgreeingDigits(fit.sigma[i], data.sigma[k]), sigma_digits)
        << "sigma " << k << " is " << fit.sigma[i] << ", certified " << data.sigma[k];
  }
}

class NonLinear : public ::testing::TestWithParam<Problem> {};

TEST_P(NonLinear, MeetsTheCertifiedValuesFromBothStarts) {
  const NistData data = ReadNist(GetParam().name);
  ASSERT_EQ(data.starts.size(), 2u);
  for (std::size_t s = 0; s < 2; ++s) {
    SCOPED_TRACE("start " + std::to_string(s + 1));
    ExpectCertified(data, GetParam().fit(data, data.starts[s]), GetParam().sigma_digits);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Nist, NonLinear,
    ::testing::Values(MakeProblem<Exponential>("misra1a"), MakeProblem<Chwirut>("chwirut2"),
                      MakeProblem<Chwirut>("chwirut1"), MakeProblem<Lanczos>("lanczos3"),
                      MakeProblem<Gauss>("gauss1"), MakeProblem<Gauss>("gauss2"),
                      MakeProblem<Power>("danwood"), MakeProblem<Misra1b>("misra1b"),
                      MakeProblem<Kirby2>("kirby2"), MakeProblem<Cubics>("hahn1"),
                      MakeProblem<Nelson, 2>("nelson"), MakeProblem<Mgh17>("mgh17"),
                      MakeProblem<Lanczos>("lanczos1", kDigitsOfRounding),
                      MakeProblem<Lanczos>("lanczos2"), MakeProblem<Gauss>("gauss3"),
                      MakeProblem<Misra1c>("misra1c"), MakeProblem<Misra1d>("misra1d"),
                      MakeProblem<Roszman1>("roszman1"), MakeProblem<Enso>("enso"),
                      MakeProblem<Mgh09>("mgh09"), MakeProblem<Cubics>("thurber"),
                      MakeProblem<Exponential>("boxbod"), MakeProblem<Rat42>("rat42"),
                      MakeProblem<Mgh10>("mgh10"), MakeProblem<Eckerle4>("eckerle4"),
                      MakeProblem<Rat43>("rat43"), MakeProblem<Bennett5>("bennett5")),
    [](const auto& test) { return test.param.name; });

class Linear : public ::testing::TestWithParam<Problem> {};

TEST_P(Linear, MeetsTheCertifiedValuesFromZero) {
  const NistData data = ReadNist(GetParam().name);
  const std::vector<double> zero(data.certified.size(), 0.0);
  ExpectCertified(data, GetParam().fit(data, zero), GetParam().sigma_digits);
}

INSTANTIATE_TEST_SUITE_P(
    Nist, Linear,
    ::testing::Values(MakeProblem<Polynomial<1>>("norris"), MakeProblem<Polynomial<2>>("pontius"),
                      MakeProblem<Proportion>("noint1"), MakeProblem<Proportion>("noint2"),
                      MakeProblem<Longley, 6>("longley"), MakeProblem<Polynomial<5>>("wampler1"),
                      MakeProblem<Polynomial<5>>("wampler2"),
                      MakeProblem<Polynomial<5>>("wampler3"),
                      MakeProblem<Polynomial<5>>("wampler4"),
                      MakeProblem<Polynomial<5>>("wampler5")),
    [](const auto& test) { return test.param.name; });

// A polynomial of degree 10 over -9 .. -3: its columns are linearly dependent to 1e-15 of their
// length. The normal equations contain no information on the last direction, which must be
// reported.
TEST(Filip, IsRefused) {
  const NistData data = ReadNist("filip");
  const std::vector<double> zero(data.certified.size(), 0.0);
  EXPECT_THROW(MakeProblem<Polynomial<10>>("filip").fit(data, zero), RankDeficient);
}

// From (1, 1) the first attempt moves the rate of BoxBOD to where the exponential has decayed.
TEST(Solve, SaysThatItEndedOnAFlat) {
  const NistData data = ReadNist("boxbod");
  Network once, twice;
  const auto b = AddNist<Exponential>(data, data.starts[0], &once);
  AddNist<Exponential>(data, data.starts[0], &twice);
  const SolveSummary first = Solve(once, {.second_attempt = false});
  const SolveSummary second = Solve(twice);
  EXPECT_GT(once.Value(b)[1], 10.0);  // the sigma of the rate is 1e40
  EXPECT_TRUE(second.converged);
  EXPECT_LT(second.final_cost, 0.2 * first.final_cost);
  EXPECT_GT(second.iterations, first.iterations);
}

// The exponential would have to be negative to fit, so every larger rate fits better, without a
// minimum.
TEST(Solve, AFlatThatRemainsIsNotConvergence) {
  Network net;
  const auto level = net.AddScalar("level", 1.0), rate = net.AddScalar("rate", 1.0);
  for (const double t : {1.0, 2.0, 3.0}) {
    const auto decay = [t](const auto& a, const auto& k) {
      using std::exp;
      return a * exp(-k * t) + 0.5;
    };
    net.Add(decay, Noise<1>::Sigma(0.01), level, rate);
  }
  net.Hold(level);
  const SolveSummary summary = Solve(net);
  EXPECT_FALSE(summary.converged);
  EXPECT_NE(summary.message.find("'rate' no longer changes the residuals"), std::string::npos)
      << summary.message;
}

}  // namespace dn::solvers_test
