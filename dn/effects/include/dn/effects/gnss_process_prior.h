#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace dn {

/// Prior of a time-correlated error of GNSS positions whose size nobody stated. It is one
/// Gauss-Markov process with sigmas east, north, up in the ratio 1 : 1 : 2.
///
///   size              sigma east over the stated sigma: log-normal, median 1/3, factor 2 per
///                     standard deviation; 95 % lie between 1/12 and 4/3
///   time constant     20 s to 600 s, at most half the flight; equally probable logarithms
///
/// Receivers of kinematic surveys state 8 mm horizontally and 15 mm vertically, and their solutions
/// state sigmas of 10 to 20 mm per epoch. The part of it that lasts for minutes is multipath and
/// troposphere: 3 to 10 mm. It is relative to the stated sigma, because geometry and ambiguities
/// change both alike.
class GnssProcessPrior {
 public:
  static constexpr double kMedianSize = 1.0 / 3.0;
  static constexpr double kLogSizeSigma = 0.6931471805599453;  // ln 2
  static constexpr double kShortestTauS = 20.0, kLongestTauS = 600.0;

  /// Returns sigma east, north, up of a process with sigma east 1.
  static Eigen::Vector3d Axes() { return {1.0, 1.0, 2.0}; }

  /// Returns the stated sigma to which sizes are relative, from sigmas east, north and up.
  static double StatedSigma(const Eigen::Vector3d& sigma_enu_m) {
    return sigma_enu_m.cwiseQuotient(Axes()).norm() / std::sqrt(3.0);
  }

  /// A size with its probability.
  struct Size {
    double size = 0.0;
    double log_probability = 0.0;
  };
  /// Returns the sizes to integrate over, as multiples of the stated sigma. They go from
  /// practically absent to ten, apart by factors of sqrt(2).
  static std::vector<Size> Sizes();

  /// Returns the time constants to integrate over, equally probable, for a flight of this length.
  static std::vector<double> TausS(double length_s);
};

}  // namespace dn
