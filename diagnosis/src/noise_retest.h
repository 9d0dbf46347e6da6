#pragma once

#include <dn/adjustment/checks.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/residual_form.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "evidence.h"
#include "hypothesis.h"
#include "noise_beyond_model.h"
#include "score_selection.h"
#include "tested_forms.h"
#include "unmodelled.h"

namespace dn::diagnosis_internal {

/// The noise that the residuals of a flight show beyond the stated one, and the tests of the flight
/// with this noise (CheckModel).
class NoiseRetest {
 public:
  /// Without noise beyond the stated one.
  NoiseRetest(const Marginals& marginals, const Library& library, const TestedForms& forms,
              const UnmodelledUnknowns& unmodelled, const TestFamily& family);

  /// Computes the residuals with all effects. `residual`: those with the unmodelled effects only.
  void TakeResidual(const Eigen::VectorXd& residual, const ScoreSelection& selection);

  /// Estimates the noise from the residuals with all effects, as TakeResidual does. Effects that
  /// this noise explains are dropped, and the noise is estimated without them. `score` is the one
  /// that the effects were selected from, and `groups` are the tests of the channels.
  void Estimate(const JointScore& score, const Eigen::VectorXd& residual,
                const std::vector<GroupCheck>& groups, ScoreSelection* selection);

  const NoiseBeyondModel& noise() const { return noise_; }

  /// Returns the residuals if the unmodelled and the found effects were estimated.
  const Eigen::VectorXd& left() const { return left_; }

  /// Returns the moments of a tested form, with the noise of the other sensors.
  const FormMoments& Moments(std::size_t form) const { return moments_[form]; }

  /// Returns whether this variance ratio of a group agrees with its own stated noise, and with the
  /// noise of the other sensors. `redundancy` is that of the group.
  bool Fits(std::size_t group, double redundancy, double ratio) const;

 private:
  bool DropExplained(const JointScore& score, ScoreSelection* selection) const;
  double PValueAtSharedNoise(std::size_t found, const ScoreSelection& selection) const;
  double CommonGrowth(const std::string& channel) const;
  double PValueAtNoise(std::size_t found, const JointScore& score,
                       const ScoreSelection& selection) const;
  std::vector<std::string> ChannelsWithOwnNoise(const std::vector<GroupCheck>& groups) const;
  void Propagate(const std::vector<GroupCheck>& groups);

  const Marginals& marginals_;
  const Library& library_;
  const TestedForms& forms_;
  const UnmodelledUnknowns& unmodelled_;
  const TestFamily& family_;
  Eigen::VectorXd left_;
  NoiseBeyondModel noise_;
  std::vector<FormMoments> moments_;
};

}  // namespace dn::diagnosis_internal
