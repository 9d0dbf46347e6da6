#pragma once

#include <dn/imu/high_band.h>

#include <array>
#include <optional>

namespace dn {

/// Noise level of one triad according to the high band of a flight.
struct NoiseLevel {
  double ratio = 0.0;  ///< actual white sigma divided by the assumed one
  double sigma = 0.0;  ///< standard deviation of the ratio if the noise is white
  std::array<double, 3> axis_ratio{};
  /// log(variance of the top octave / variance of the octave below) and its standard deviation;
  /// white noise has tilt 0.
  double tilt = 0.0;
  double tilt_sigma = 0.0;
};

/// Additional white noise of the samples of both triads during one window.
struct NoiseWindow {
  double t0_s = 0.0;
  double t1_s = 0.0;
  /// Sigma of one sample: rad/s, m/s^2; 0: no additional noise.
  std::array<double, kImuTriads> sigma{};
  /// Standard deviation of sigma. If sigma does not exceed it: root of the standard deviation of
  /// sigma^2.
  std::array<double, kImuTriads> sigma_of_sigma{};
  /// Log-likelihood relative to the assumed noise alone, nats.
  double log_likelihood = 0.0;
  /// Log-likelihood relative to noise of another level during the whole flight, nats.
  double log_likelihood_against_scale = 0.0;
};

/// Log Bayes factors of the hypotheses about the high band, relative to the assumed noise, nats.
struct NoiseEvidence {
  /// White noise of another level during the whole flight.
  std::array<double, kImuTriads> scale{};
  /// Additional white noise of both triads in one window at any time.
  double window = 0.0;
  /// White noise of another level during the whole flight, and additional noise in one window.
  double window_and_scale = 0.0;
  /// The levels of axes and octaves differ: the noise is not white, or not the same in all axes.
  std::array<double, kImuTriads> coloured{};
  /// The level differs between windows, because of intermittent vibration or motion.
  std::array<double, kImuTriads> unsteady{};
};

/// Hypotheses about the noise in the high band.
enum class NoiseHypothesis {
  kAssumed,         ///< the assumed noise
  kScale,           ///< white noise of another level in one triad or both
  kWindow,          ///< additional white noise in a window
  kWindowAndScale,  ///< additional white noise in a window, and another level elsewhere
  /// Coloured or unsteady noise in one triad or both, from vibration or motion in this band.
  kNotWhite
};

/// Returns the hypothesis with the largest evidence. Each triad uses its own best hypothesis where
/// the joint one allows it.
NoiseHypothesis BestHypothesis(const NoiseEvidence& evidence);

/// Log Bayes factors of the best hypothesis with a cause relative to the best one without it, nats.
/// They can be compared with other causes of a misfit. The comparison is needed because the
/// hypotheses resemble each other. Noise of another level looks like a window as long as the
/// flight; a window looks like another level and like unsteady noise.
struct NoiseCauses {
  /// Noise of another level in this triad. The other triad may follow any hypothesis, including
  /// coloured or unsteady noise.
  std::array<double, kImuTriads> scale{};
  double window = 0.0;  ///< a window, among the hypotheses with white noise
  /// This triad is coloured or unsteady, relative to the best hypothesis in which it is white. A
  /// positive value lowers `scale` and `window` by the same amount.
  std::array<double, kImuTriads> not_white{};
};

/// Computes the log Bayes factors of the causes from those of the hypotheses.
NoiseCauses NoiseCauseEvidence(const NoiseEvidence& evidence);

/// Prior assumptions about the size of the noise.
struct NoiseCheckOptions {
  /// log(ratio) is normal about 0. Its standard deviation is log(typical_ratio) times 0.1, 0.32, 1,
  /// 3.2 or 10, with probabilities 0.1, 0.2, 0.4, 0.2, 0.1.
  double typical_ratio = 1.5;
  /// log10 of the sigma added in a window is normal about log10 of these values, with standard
  /// deviation spread_decades.
  std::array<double, kImuTriads> typical_sigma{1.745e-3, 0.3};
  double spread_decades = 0.7;

  /// Throws InvalidConfig if typical_ratio is not above 1 or another value is not positive.
  void Validate() const;
};

/// Results of the noise check of the inertial sensors by their high band.
struct NoiseCheck {
  /// Level of each triad; absent if the triad is unusable.
  std::array<std::optional<NoiseLevel>, kImuTriads> level;
  /// Most likely window; absent if no window has more noise than assumed.
  std::optional<NoiseWindow> window;
  /// Most likely window if the noise outside it has its own level.
  std::optional<NoiseWindow> window_with_scale;
  NoiseEvidence evidence;
};

/// Computes levels, windows and evidences. Let E be the energy and n its degrees of freedom, where
/// the variance is v times the assumed one. Then
///
///   log L(v) = -1/2 (n log v + E / v),
///
/// and every evidence is the integral of L(v) / L(1) over the prior of its parameters. For levels,
/// L is approximated as normal in log(v); for the sigmas of a window the integral is numerical. The
/// evidence of a window is the average over all windows of the grid (any start, any end). The
/// levels of axes and octaves are normal about a common level. Their spread is one of six values
/// between 0.003 and 1 (logarithm of sigma) with equal probabilities.
///
/// Windows begin and end at multiples of two seconds, or of 1/500 of the flight if that is longer.
/// Near the most likely window of this grid, any window of the band is possible. Throws as
/// NoiseCheckOptions::Validate.
NoiseCheck CheckNoise(const HighBand& band, const NoiseCheckOptions& options = {});

}  // namespace dn
