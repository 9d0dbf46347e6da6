#include "noise_retest.h"

#include <dn/distributions.h>
#include <dn/effects/effect_table.h>

#include <algorithm>
#include <string>

#include "effect_rows.h"
#include "joint_estimate.h"

namespace dn::diagnosis_internal {

NoiseRetest::NoiseRetest(const Marginals& marginals, const Library& library,
                         const TestedForms& forms, const UnmodelledUnknowns& unmodelled,
                         const TestFamily& family)
    : marginals_(marginals),
      library_(library),
      forms_(forms),
      unmodelled_(unmodelled),
      family_(family),
      moments_(forms.TestedMoments()) {}

void NoiseRetest::TakeResidual(const Eigen::VectorXd& residual, const ScoreSelection& selection) {
  left_ = residual;
  if (selection.chosen.empty()) return;
  left_ = ResidualWith(library_, marginals_,
                       unmodelled_.EstimateBeside(selection.joint) + selection.joint);
}

void NoiseRetest::Estimate(const JointScore& score, const Eigen::VectorXd& residual,
                           const std::vector<GroupCheck>& groups, ScoreSelection* selection) {
  do {
    TakeResidual(residual, *selection);
    noise_ = forms_.EstimateNoise(groups, left_);
  } while (DropExplained(score, selection));
  Propagate(groups);
}

bool NoiseRetest::Fits(std::size_t group, double redundancy, double ratio) const {
  FormMoments expected = moments_[group];
  const double mean = forms_.moments[group].mean;
  if (mean > 0.0) expected.mean *= redundancy / mean;
  return family_.FamilyWise(expected.UpperTail(ratio * redundancy)) > kFamilyLevel;
}

/// Tests the found effects again, at the noise that the residuals have with all of them. Drops
/// those that are not significant any more, and returns whether there were any.
bool NoiseRetest::DropExplained(const JointScore& score, ScoreSelection* selection) const {
  std::vector<std::size_t> kept;
  for (std::size_t k = 0; k < selection->chosen.size(); ++k) {
    const double p =
        std::max(PValueAtSharedNoise(k, *selection), PValueAtNoise(k, score, *selection));
    selection->effects[k].p_value = family_.FamilyWise(p);
    if (selection->effects[k].p_value <= kFamilyLevel) kept.push_back(k);
  }
  if (kept.size() == selection->chosen.size()) return false;
  *selection = Keep(*selection, kept, score, family_);
  return true;
}

/// Returns the p-value of a found effect if its columns agree as well as possible with the errors
/// that the residuals of its sensor share. Clusters of pairs, or windows of time, may be few.
double NoiseRetest::PValueAtSharedNoise(std::size_t found, const ScoreSelection& selection) const {
  const ScoreTest& test = selection.tests[found];
  const EffectSensor sensor = EffectRow(*selection.chosen[found].id).sensor;
  double growth = 1.0;
  if (sensor == EffectSensor::kLidar) growth = noise_.PairGrowth();
  if (sensor == EffectSensor::kGnss) growth = CommonGrowth("gnss position");
  return ChiSquareTail(test.statistic / growth, test.dof);
}

/// Returns the largest significant ratio of the common errors of a channel, with all effects; at
/// least 1.
double NoiseRetest::CommonGrowth(const std::string& channel) const {
  double largest = 1.0;
  for (std::size_t c = forms_.channels; c < forms_.tested; ++c) {
    if (forms_.all[c].channel != channel) continue;
    const FormMoments& moments = forms_.moments[c];
    const double energy = forms_.all[c].Energy(left_);
    if (family_.FamilyWise(moments.UpperTail(energy)) > kFamilyLevel) continue;
    largest = std::max(largest, energy / std::max(moments.mean, 1e-300));
  }
  return largest;
}

/// Returns the p-value of a found effect beside the others. The covariance of its score is that of
/// the stated noise and of the noise beyond it.
double NoiseRetest::PValueAtNoise(std::size_t found, const JointScore& score,
                                  const ScoreSelection& selection) const {
  std::vector<HypothesisEvidence> others = selection.chosen;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(found));
  const JointColumns own = CombineFixed({selection.chosen[found]}, score);
  const JointColumns beside = CombineFixed(others, score);
  // The columns of the effect, as far as the others do not take their part.
  Eigen::MatrixXd left = own.T;
  if (beside.T.cols() > 0) {
    left -= beside.T * beside.Information(score).completeOrthogonalDecomposition().solve(
                           beside.T.transpose() * score.A * own.T);
  }
  const Eigen::MatrixXd gain =
      marginals_.Project(EffectRows(library_, marginals_.linearized(), unmodelled_.Follow(left)));
  const ScoreTest test = TestScore(left.transpose() * score.s,
                                   left.transpose() * score.A * left + noise_.AddedCovariance(gain),
                                   own.T.cwiseAbs2().transpose() * score.signature2);
  return test.dof > 0 ? ChiSquareTail(test.statistic, test.dof) : 1.0;
}

/// Returns the channels with noise beyond the stated one. Leaves out those whose residuals show the
/// errors of other sensors more than their own.
std::vector<std::string> NoiseRetest::ChannelsWithOwnNoise(
    const std::vector<GroupCheck>& groups) const {
  constexpr double kOwnShare = 0.5;
  std::vector<std::string> channels = noise_.Channels();
  std::erase_if(channels, [&](const std::string& channel) {
    return std::any_of(groups.begin(), groups.end(), [&](const GroupCheck& group) {
      return group.name == channel &&
             group.redundancy < kOwnShare * static_cast<double>(group.observations);
    });
  });
  return channels;
}

/// Computes the moments of the tested forms if the noise of the other ChannelsWithOwnNoise is as
/// large as their residuals show. A trajectory that follows errors of the pairs has larger inertial
/// residuals.
void NoiseRetest::Propagate(const std::vector<GroupCheck>& groups) {
  const bool suspicious = std::any_of(groups.begin(), groups.end(), [](const GroupCheck& group) {
    return group.variance_ratio > 1.0 && group.p_value <= kFamilyLevel;
  });
  const std::vector<std::string> channels = ChannelsWithOwnNoise(groups);
  if (!suspicious || channels.empty()) return;
  moments_ = MomentsWithNoise(forms_.Tested(), marginals_, noise_, channels);
}

}  // namespace dn::diagnosis_internal
