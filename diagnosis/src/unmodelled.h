#pragma once

#include <dn/diagnosis/model_check.h>
#include <dn/effects/unmodelled_prior.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "gnss_process.h"
#include "hypothesis.h"
#include "hypothesis_evidence.h"
#include "process_mixture.h"

namespace dn::diagnosis_internal {

/// The effects of a library that have a prior, as further unknowns of an adjustment: conditioning
/// of its joint score, to first order. `library` must outlive the object.
///
/// With a process, its coefficients are further unknowns. Their distribution is that over all sizes
/// and time constants (ProcessMixture). It is that of a Gaussian with the mean and covariance of
/// this mixture in all results but Conditioned.
class UnmodelledUnknowns {
 public:
  /// `score` is that of the library without any of its effects in the model.
  UnmodelledUnknowns(const Library& library, const UnmodelledPrior& prior, const JointScore& score,
                     const std::optional<GnssProcessBasis>& process = std::nullopt,
                     SizeSource source = SizeSource::kDataAndPrior);

  bool empty() const { return components_.empty(); }

  /// Components of the score with a prior, those of the process last.
  const std::vector<Eigen::Index>& components() const { return components_; }

  /// Returns the distribution of the process; nullopt without it.
  const std::optional<ProcessMixture>& process() const { return process_; }

  /// Returns the joint posterior of the fixed effects and of the unknowns in the rows of
  /// JointScore::shift.
  EffectPosterior Posterior() const;

  /// Returns a square root of the posterior covariance of components(), SI.
  Eigen::MatrixXd PosteriorRoot() const;

  /// Returns the posterior means, SI: one per component of the score, 0 for those without a prior.
  const Eigen::VectorXd& estimate() const { return estimate_; }

  /// Returns the posterior means if other effects have the values `others`, SI, one value per
  /// component of the score.
  Eigen::VectorXd EstimateBeside(const Eigen::VectorXd& others) const;

  /// Returns the values of all components if those of other effects are the columns of X, and these
  /// unknowns follow them. They are X - (A + D^-1)^-1 A X. One row per component of the score.
  Eigen::MatrixXd Follow(const Eigen::MatrixXd& X) const;

  /// Returns the scores of all components in the model with these unknowns. That of a component
  /// with a prior is the score of what the effect has beyond its prior. The process has the
  /// Gaussian prior ProcessMixture::prior_sigma.
  JointScore Conditioned() const;

  /// Returns the change of the watched unknowns in the rows of JointScore::shift.
  Eigen::VectorXd Correction() const { return -score_.shift * estimate_; }
  /// Returns (A + D^-1)^-1 S^T: one row per component of the score, and one column per row of
  /// JointScore::shift. An error e of the residuals changes the correction by the transpose of this
  /// times L^T M e.
  Eigen::MatrixXd Gain() const;
  /// Returns the covariance that these unknowns add to the rows of JointScore::shift.
  Eigen::MatrixXd AddedCovariance() const;

  /// Returns the covariance that these unknowns add to the rows of JointScore::shift if the
  /// watched unknowns are not corrected for them: S D S^T.
  Eigen::MatrixXd PriorCovariance() const;

  /// Returns the contributions to angles, the largest first. Each element of `angle_rows` is the
  /// first of three rows of JointScore::shift; the mean of their variances counts. `corrected`
  /// tells whether these are corrected for the effects.
  std::vector<EffectContribution> Contributions(const std::vector<Eigen::Index>& angle_rows,
                                                bool corrected = true) const;

 private:
  void AddProcess(const GnssProcessBasis& process, SizeSource source);
  EffectContribution ProcessContribution(const std::vector<Eigen::Index>& angle_rows) const;

  const Library& library_;
  const JointScore& score_;
  std::vector<Eigen::Index> components_;    // those with a prior
  std::vector<Eigen::Index> fixed_;         // those of fixed effects
  std::vector<EffectId> effect_;            // effect of each of the fixed_
  std::vector<Eigen::Index> within_;        // its index within the effect
  Eigen::VectorXd sigma_;                   // prior standard deviations of the fixed_
  Eigen::LLT<Eigen::MatrixXd> llt_;         // of I + sigma A sigma, A of the fixed_
  Eigen::MatrixXd inverse_;                 // its inverse
  std::vector<Eigen::Index> coefficients_;  // components of the process
  std::optional<ProcessMixture> process_;
  Eigen::MatrixXd response_;    // change of the fixed_ per unit of the coefficients_
  Eigen::MatrixXd covariance_;  // posterior, of the components_
  Eigen::VectorXd estimate_;
};

/// Returns the largest component of an effect in standard deviations of its prior, or nullopt
/// without a prior; estimate and its sigma in SI. Components below three of their own sigmas count
/// only if all are.
std::optional<double> InPriorSigmas(const UnmodelledPrior& prior, EffectId effect,
                                    const Eigen::VectorXd& estimate_si,
                                    const Eigen::VectorXd& sigma_si);

/// Compares the effects that a selection found with their priors. `chosen` has their joint
/// estimates, in the same order.
void SetPriorSigmas(const UnmodelledPrior& prior, const std::vector<HypothesisEvidence>& chosen,
                    std::vector<EffectCheck>* effects);

}  // namespace dn::diagnosis_internal
