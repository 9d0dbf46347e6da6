#pragma once

#include <dn/files/flight.h>

#include <optional>

namespace dn {

/// Delay of the GNSS tags against the inertial data, from the motion that both measure.
struct GnssLag {
  double lag_s = 0.0;    ///< tag = t + lag
  double sigma_s = 0.0;  ///< standard deviation of lag_s
  double gain = 0.0;     ///< ln of the likelihood ratio of lag_s and lag 0
  /// True if lag_s is decisively better than all lags that are not its neighbours. It must also fit
  /// nearly as well as the noise of the positions allows. Otherwise the motion repeats itself, the
  /// files belong to different flights, or the true lag is beyond the search.
  bool certain = false;
};

/// Searches delays of the GNSS tags of up to two minutes. It needs neither initial values nor a
/// stochastic model of the inertial unit.
///
/// The GNSS positions are divided into windows of half a minute or longer. For each lag and window,
/// the second differences of the positions are compared with those of the inertial data:
///
///   beta_k = R (alpha_k + (theta + b_g t_k) x alpha_k + q_k b_a) + noise,
///
/// with alpha and beta as in the in-flight alignment. The attitude R, its correction theta and the
/// biases b_g, b_a are unknowns of the window. Each window has a noise of its own, so that a
/// disturbed window does not dominate the likelihood of a lag.
///
/// Returns nullopt if lag 0 fits as well as the noise of the positions allows, or if no other lag
/// is decisively better. Also returns nullopt if the best lag is shorter than 2 s: an adjustment
/// finds such lags with better accuracy. The search takes 0.3 s for ten minutes at 1 Hz.
std::optional<GnssLag> FindGnssLag(const Flight& flight);

/// Returns true if the motion confirms the GNSS tags within 2 s. Lag 0 then fits as well as the
/// noise of the positions allows, or a lag below 2 s decisively better than all longer ones.
/// Otherwise inertial data and GNSS may belong to different motions, or vibration and noise hide
/// the motion.
bool GnssTagsFit(const Flight& flight);

}  // namespace dn
