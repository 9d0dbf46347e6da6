#include "smallest_p_value.h"

#include <dn/distributions.h>
#include <dn/solvers/fit_check.h>
#include <dn/solvers/prediction.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>
#include <vector>

#include "common_errors.h"
#include "network_hypotheses.h"
#include "testing/short_flights.h"

namespace dn::diagnosis_test {

using diagnosis_internal::EffectiveTests;
using diagnosis_internal::FamilyPValue;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(SmallestPValue, IndependentTestsCountEachAndEqualTestsCountOnce) {
  constexpr int kReplicates = 4000;
  constexpr double kFourSigmas = 4.0 / 63.0;  // relative error of the estimate is 1 / sqrt(4000)
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform;
  for (const int tests : {1, 5, 60}) {
    VectorXd smallest = VectorXd::Ones(kReplicates);
    for (double& p : smallest) {
      for (int k = 0; k < tests; ++k) p = std::min(p, uniform(random));
    }
    EXPECT_NEAR(EffectiveTests(smallest) / tests, 1.0, kFourSigmas);
  }
  EXPECT_NEAR(FamilyPValue(0.01, 1.0), 0.01, 1e-15);
  EXPECT_NEAR(FamilyPValue(1e-12, 50.0), 5e-11, 1e-20);
  EXPECT_EQ(FamilyPValue(1.0, 50.0), 1.0);
}

/// The tests of a flight of its own model, for any residuals.
class NullFlight {
 public:
  NullFlight()
      : sim_(testing::Fly(testing::DroneScenario(), 7)),
        calibration_(sim_.flight),
        linearized_(calibration_.marginals.linearized()),
        forms_(ChannelForms(linearized_)),
        redundancy_(static_cast<Index>(forms_.size())),
        library_(diagnosis_internal::MakeNetworkHypotheses(network(), 1, {})),
        score_(ScoreEffects(calibration_.marginals, library_.blocks, {})) {
    const VectorXd of_rows = RedundancyNumbers(calibration_.marginals);
    for (std::size_t k = 0; k < forms_.size(); ++k) {
      redundancy_[static_cast<Index>(k)] = forms_[k].Energy(of_rows.cwiseMax(0.0).cwiseSqrt());
    }
    std::vector<ResidualForm> common = diagnosis_internal::CommonErrorForms(network(), linearized_);
    std::move(common.begin(), common.end(), std::back_inserter(forms_));
    const MatrixXd energies = SampleFormEnergies(calibration_.marginals, forms_);
    moments_ = ComputeFormMoments(calibration_.marginals, forms_, energies);
    tests_ =
        EffectiveTests(diagnosis_internal::SmallestFormPValues(moments_, energies, redundancy_)) +
        EffectiveTests(diagnosis_internal::SmallestScorePValues(library_, score_, 400));
  }

  /// Returns the p-values of draws from the model.
  std::vector<double> Draw(Index draws) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    MatrixXd R(linearized_.rows(), draws);
    for (double& e : R.reshaped()) e = normal(random);
    R = calibration_.marginals.Project(R);
    MatrixXd s(score_.s.size(), draws);
    for (std::size_t k = 0; k < library_.blocks.size(); ++k) {
      s(score_.Components(k), Eigen::all) = TransposeTimes(linearized_, library_.blocks[k], R);
    }
    std::vector<double> p;
    for (Index k = 0; k < draws; ++k) p.push_back(PValue(R.col(k), s.col(k)));
    return p;
  }

  double tests() const { return tests_; }
  double all_tests() const {
    return static_cast<double>(forms_.size() + library_.hypotheses.size());
  }

 private:
  const FlightNetwork& network() const { return *calibration_.adjustment.network; }

  double PValue(const VectorXd& residual, const VectorXd& s) {
    score_.s = s;
    double smallest = diagnosis_internal::SmallestEffectPValue(library_, score_);
    for (std::size_t k = 0; k < forms_.size(); ++k) {
      const auto form = static_cast<Index>(k);
      const double energy = forms_[k].Energy(residual);
      smallest = std::min(smallest, form < redundancy_.size()
                                        ? ChannelPValue(redundancy_[form], moments_[k], energy)
                                        : moments_[k].UpperTail(energy));
    }
    return FamilyPValue(smallest, tests_);
  }

  SimulatedFlight sim_;
  testing::Calibration calibration_;
  const LinearizedNetwork& linearized_;
  std::vector<ResidualForm> forms_;
  VectorXd redundancy_;  // of the channels
  diagnosis_internal::Library library_;
  JointScore score_;
  std::vector<FormMoments> moments_;
  double tests_ = 0.0;
};

TEST(SmallestPValue, IsUniformUnderTheModel) {
  constexpr int kSamples = 1000;
  constexpr double kBand = 3.5;
  // Sums of squares and scores count as independent, which gives up to a third too many tests.
  constexpr double kTests = 0.33;
  NullFlight flight;
  EXPECT_LT(flight.tests(), flight.all_tests());
  const std::vector<double> p = flight.Draw(kSamples);
  for (const double level : {0.01, 0.05, 0.2}) {
    const auto below = std::count_if(p.begin(), p.end(), [&](double one) { return one <= level; });
    const double share = static_cast<double>(below) / kSamples;
    const double sampling = std::sqrt(level * (1.0 - level) / kSamples);
    EXPECT_NEAR(share, level, kBand * sampling + kTests * level) << level;
    RecordProperty("below_" + std::to_string(level), std::to_string(share));
  }
  double mean = 0.0;
  for (const double one : p) mean += one / kSamples;
  EXPECT_NEAR(mean, 0.5, 0.5 * kTests / (2.0 + kTests));
  RecordProperty("mean", std::to_string(mean));
}

}  // namespace dn::diagnosis_test
