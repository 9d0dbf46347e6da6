#pragma once

#include <dn/imu/high_band.h>

#include <array>
#include <optional>

namespace dn {

/// What the high band of a flight says of one triad.
struct NoiseLevel {
  double ratio = 0.0;  ///< actual white sigma over the assumed one
  double sigma = 0.0;  ///< of the ratio, were the noise white
  std::array<double, 3> axis_ratio{};
  /// log(variance of the top octave / variance of the octave below), 0 for white noise, and its
  /// standard deviation.
  double tilt = 0.0;
  double tilt_sigma = 0.0;
};

/// White noise of every sample of both triads that is there in one window only.
struct NoiseWindow {
  double t0_s = 0.0;
  double t1_s = 0.0;
  std::array<double, kImuTriads> sigma{};           ///< of a sample: rad/s, m/s^2; 0: none
  std::array<double, kImuTriads> sigma_of_sigma{};  ///< standard deviation of that; of sigma^2, its
                                                    ///< root, where sigma is not above it
  double log_likelihood = 0.0;                      ///< against the assumed noise alone, nats
  double log_likelihood_over_flight = 0.0;  ///< against a noise of another size over the flight
};

/// How well each account of the high band does against the assumed noise: log Bayes factors, nats.
struct NoiseEvidence {
  /// White noise of another size over the whole flight.
  std::array<double, kImuTriads> scale{};
  /// Additional white noise of both triads in one window, whichever.
  double window = 0.0;
  /// Both at once: the noise has its own size outside the window.
  double window_and_scale = 0.0;
  /// The levels of the axes and octaves differ: not white, or not the same in all axes.
  std::array<double, kImuTriads> coloured{};
  /// The level differs from window to window: vibration that comes and goes, motion.
  std::array<double, kImuTriads> unsteady{};
};

/// Accounts of the high band.
enum class NoiseAccount {
  kAssumed,         ///< the stated noise
  kScale,           ///< white noise of another size in one triad or both
  kWindow,          ///< more white noise in a window
  kWindowAndScale,  ///< both
  kNotWhite         ///< coloured or unsteady, in one triad or both: vibration, or motion as fast
};

/// The account with the largest evidence, each triad having the best for itself where it can.
NoiseAccount BestAccount(const NoiseEvidence& evidence);

/// How far the best account with a cause is ahead of the best one without it, nats: what is to be
/// compared with other causes of a misfit, since a noise of another size also looks like a window
/// as long as the flight, and a window like another size and like noise that comes and goes.
struct NoiseCauses {
  /// Another size in this triad; the other one may have any account, not white ones as well.
  std::array<double, kImuTriads> scale{};
  double window = 0.0;  ///< among accounts by white noise
  /// This triad coloured or unsteady, before the best account by which it is white. Where it is
  /// positive, `scale` and `window` are less by so much.
  std::array<double, kImuTriads> not_white{};
};

NoiseCauses CausesOf(const NoiseEvidence& evidence);

/// What is expected of sizes before any data are seen.
struct NoiseCheckOptions {
  /// log(ratio) is normal about 0, its standard deviation log(typical_ratio) times 0.1, 0.32, 1,
  /// 3.2 or 10 with the probabilities .1, .2, .4, .2, .1.
  double typical_ratio = 1.5;
  /// log10 of the sigma that a window adds is normal about that of these, with spread_decades.
  std::array<double, kImuTriads> typical_sigma{1.745e-3, 0.3};
  double spread_decades = 0.7;

  /// Throws InvalidConfig for a ratio that is not above 1, or another value that is not positive.
  void Validate() const;
};

/// The noise of the inertial sensors, judged by their high band.
struct NoiseCheck {
  /// Nothing where the triad is unusable.
  std::array<std::optional<NoiseLevel>, kImuTriads> level;
  /// The likeliest window; nothing where no window has more noise than assumed.
  std::optional<NoiseWindow> window;
  /// The same when the noise outside it has its own size.
  std::optional<NoiseWindow> window_beside_scale;
  NoiseEvidence evidence;
};

/// Levels, windows and evidences. With E the energy and n its degrees of freedom where the variance
/// is v times the assumed one,
///
///   log L(v) = -1/2 (n log v + E / v),
///
/// and every evidence is the integral of L(v) / L(1) over the prior of its parameters: with L
/// normal in log(v) for levels, numerically for a window's sigmas, and over all windows of
/// the grid (any start, any end) as their average. Levels that differ are normal about a common
/// one with a spread of 0.003 to 1 (of the logarithm of sigma, six values alike).
///
/// Windows begin and end on multiples of two seconds, or of a five-hundredth of the flight where
/// that is longer; near the likeliest of these on any window of the band. Throws as
/// NoiseCheckOptions::Validate.
NoiseCheck CheckNoise(const HighBand& band, const NoiseCheckOptions& options = {});

}  // namespace dn
