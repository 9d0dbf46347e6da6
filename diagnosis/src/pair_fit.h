#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "forward_selection.h"
#include "linear_pairs.h"
#include "pair_library.h"
#include "screen.h"
#include "time_correlated_errors.h"

namespace dn::diagnosis_internal {

/// Pairs on a fixed trajectory with some effects among the unknowns.
struct PairFit : ExtendedFit {
  ErrorScale scale;   ///< most probable scale with the chosen effects
  double chi2 = 0.0;  ///< at this scale
  /// Evidence of this scale of the trajectory errors against the stated one.
  double larger_errors_nats = 0.0;
  std::unique_ptr<Screen> with_stated_errors;  ///< with trajectory errors of the stated size
  double chi2_with_stated_errors = 0.0;
  std::unique_ptr<Screen> screen;  ///< at this scale, with the chosen effects
  long outliers = 0;  ///< rejected pairs that trajectory errors do not explain; 0 if not counted
  /// Covariance added by the chosen effects.
  Eigen::Matrix3d boresight_covariance_rad2 = Eigen::Matrix3d::Zero();
};

/// Evidence of lidar effects with time-correlated trajectory errors in the model
/// (TimeCorrelatedErrorModel). It is not known how much of the stated trajectory errors is
/// independent between pairs. The noise of the pairs is therefore free between its own stated size
/// and that with all these errors. The trajectory errors may be larger than stated, by octaves. The
/// evidence of an effect is the largest log likelihood with it minus the largest without it, each
/// over all scales.
class PairFitter {
 public:
  /// `library` must outlive the object.
  PairFitter(const PairLibrary& library, const LinearPairs& pairs,
             const std::vector<StripInterval>& strips, bool with_noise_scale);

  /// Estimates the chosen effects and evaluates all others.
  PairFit Fit(const std::vector<HypothesisEvidence>& chosen);

  double observations() const { return observations_; }
  /// Returns the ratio of the pairs' own noise to its upper limit, as standard deviations.
  double min_white() const { return min_white_; }
  /// Returns the evidence of scaled white noise of the pairs, assuming that chi2 is chi-square
  /// distributed.
  double NoiseEvidence(double chi2) const;

 private:
  struct Height;
  class Search;
  const TimeCorrelatedErrorModel::ScaleSolution& At(const ErrorOctaves& octaves, double white);

  const PairLibrary& library_;
  TimeCorrelatedErrorModel errors_;
  bool with_noise_scale_;
  double observations_ = 0.0;
  double min_white_ = 1.0;  // ratio of the pairs' own noise to its upper limit
  std::map<std::pair<ErrorOctaves, double>, TimeCorrelatedErrorModel::ScaleSolution> known_;
};

}  // namespace dn::diagnosis_internal
