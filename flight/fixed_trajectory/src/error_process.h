#pragma once

namespace dn::internal {

/// A process of unit variance in time, for an error of a trajectory.
struct ErrorProcess {
  enum class Kind {
    kGaussMarkov,  ///< exp(-d / tau)
    kPerStrip,     ///< constant in a strip, new after every turn
  };
  Kind kind = Kind::kGaussMarkov;
  double tau_s = 0.0;  ///< of the first

  bool operator==(const ErrorProcess&) const = default;

  /// Correlation at two epochs that are apart_s apart.
  double Correlation(double apart_s, bool same_strip) const;
};

/// Processes of the errors of positions and of attitudes.
struct ErrorModel {
  ErrorProcess position;
  ErrorProcess attitude;
  /// The tilt keeps its direction in the navigation frame when the aircraft turns: roll and pitch
  /// errors of opposite strips are opposite. Else the aircraft takes them along.
  bool tilt_in_nav = false;
};

}  // namespace dn::internal
