#pragma once

#include <dn/calibration/lasting_errors.h>
#include <dn/calibration/linear_pairs.h>

#include <Eigen/Core>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "gauss_helmert_library.h"
#include "screen.h"

namespace dn::internal {

/// Pairs on a given trajectory with some effects among the unknowns, and what else they show.
struct ExplainedPairs {
  std::vector<ScreenedEffect> chosen;  ///< with their estimates side by side
  std::vector<ScreenedEffect> others;  ///< the likeliest first
  ErrorScale scale;                    ///< the likeliest with those chosen
  double chi2 = 0.0;                   ///< at it
  double larger_errors_nats =
      0.0;  ///< for that scale of the trajectory's errors against the stated
  std::unique_ptr<Screen> at_stated;  ///< beside errors of the stated size
  double chi2_at_stated = 0.0;
  std::unique_ptr<Screen> screen;  ///< at that scale, beside those chosen
  Eigen::Matrix3d boresight_covariance_rad2 = Eigen::Matrix3d::Zero();  ///< added by them
};

/// What speaks for effects of the lidar beside errors of the trajectory that last (LastingErrors).
/// How much of the stated errors of the trajectory is new in every pair is not stated, so the noise of
/// the pairs is free from its own stated size up to that with all of them. The trajectory's errors may be larger than stated, by octaves: evidence of an effect is the
/// largest log likelihood with it over the largest without, each over all scales.
class GaussHelmertEvidence {
 public:
  /// The library must outlive it.
  GaussHelmertEvidence(const GaussHelmertLibrary& library, const LinearPairs& pairs,
                       const std::vector<StripInterval>& strips, bool with_noise_scale);

  ExplainedPairs Explain(const std::vector<ScreenedEffect>& chosen);

  double observations() const { return observations_; }
  /// Of the pairs' own noise in the noise at its largest, as standard deviations.
  double least_white() const { return least_white_; }
  /// Evidence for a factor of the pairs' white noise if chi2 has a chi-square distribution.
  double NoiseEvidence(double chi2) const;

 private:
  struct Octaves {
    int position = 0, attitude = 0;
    auto operator<=>(const Octaves&) const = default;
  };
  struct Height;
  class Search;
  const LastingErrors::AtScale& At(const Octaves& octaves, double white);

  const GaussHelmertLibrary& library_;
  LastingErrors errors_;
  bool with_noise_scale_;
  double observations_ = 0.0;
  double least_white_ = 1.0;  // the pairs' own noise
  std::map<std::tuple<int, int, double>, LastingErrors::AtScale> known_;
};

}  // namespace dn::internal
