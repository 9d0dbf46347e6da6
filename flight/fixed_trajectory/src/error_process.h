#pragma once

namespace dn::fixed_trajectory_internal {

/// A stochastic process of unit variance in time that models a trajectory error.
struct ErrorProcess {
  enum class Kind {
    kGaussMarkov,  ///< correlation exp(-d / tau) at time difference d
    kPerStrip,     ///< constant within a strip, independent between strips
  };
  Kind kind = Kind::kGaussMarkov;
  double tau_s = 0.0;  ///< only for kGaussMarkov

  bool operator==(const ErrorProcess&) const = default;

  /// Returns the correlation between two epochs whose time difference is apart_s.
  double Correlation(double apart_s, bool same_strip) const;
};

/// Processes of the position and attitude errors.
struct ErrorModel {
  ErrorProcess position;
  ErrorProcess attitude;
  /// If true, the tilt error keeps its direction in the navigation frame when the aircraft turns.
  /// Roll and pitch errors then have opposite signs on opposite strips. If false, the error is
  /// fixed in the body frame.
  bool tilt_in_nav = false;
};

}  // namespace dn::fixed_trajectory_internal
