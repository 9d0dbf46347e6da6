#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <numbers>

namespace dn {

/// Quantity in proportion to which a time-correlated GNSS error grows.
enum class GnssErrorGrowth {
  kNone,  ///< the error has the same size during the whole flight
  kBank   ///< the error is proportional to |roll| and vanishes in level flight
};

/// Roll at which an error that grows with the bank has its stated standard deviations.
inline constexpr double kReferenceBankRad = std::numbers::pi / 6.0;

/// Time-correlated error of the GNSS positions: one first-order Gauss-Markov process on each local
/// east, north and up axis of the point. The axes are independent.
struct GnssProcess {
  /// Stationary standard deviation; 0: no error on that axis. For kBank it applies at a roll of
  /// kReferenceBankRad.
  Eigen::Vector3d sigma_enu_m = Eigen::Vector3d::Zero();
  double tau_s = 0.0;  ///< correlation time
  GnssErrorGrowth growth = GnssErrorGrowth::kNone;

  friend bool operator==(const GnssProcess&, const GnssProcess&) = default;
};

}  // namespace dn
