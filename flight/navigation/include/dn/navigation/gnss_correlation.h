#pragma once

#include <dn/builder/flight_network.h>
#include <dn/gnss/gnss_process.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>

namespace dn {

/// Whether the GNSS positions of a flight have errors that last and that its network lacks. Vectors
/// are of local east, north, up.
struct GnssCorrelation {
  Eigen::Vector3d lag1 = Eigen::Vector3d::Zero();           ///< of successive residuals
  Eigen::Vector3d lag1_expected = Eigen::Vector3d::Zero();  ///< where all errors are modelled
  /// For the family of every axis, all together, and all times.
  Eigen::Vector3d p_value = Eigen::Vector3d::Ones();
  double p_value_together = 1.0;
  GnssProcess process;  ///< the one that fits best; no sigmas where none does

  /// At a thousandth of the flights without such errors.
  bool significant() const;
};

/// Score tests of a Gauss-Markov process on each axis, of correlation times tau from two epochs to a
/// fifth of the flight. With y = L^T r, the whitened residuals' derivative by an error of the axis,
/// and K(tau) its correlations between the epochs,
///
///   T = y^T K y / E[y^T K y] / (y^T y / E[y^T y])
///
/// of an axis, or the sum over the axes, is a chi-square variable with the moments that it has over
/// samples of the residuals that the network leaves when its model holds (ForSampledResiduals): what
/// the trajectory follows of an error is accounted for, and white noise that is larger than stated
/// raises no alarm. `process` is the one whose expected energies y^T K y at all tau are nearest to
/// those of the data: a proposal, good to a factor of two of sigma^2 / tau.
///
/// `marginals` must be of the INS/GNSS network at its solution: lidar pairs with an error of their
/// own would pull the trajectory. Fewer than 20 positions in use are not tested.
///
/// Source: Rao's score for a variance component at zero, u = (||L^T r||^2 - tr(L^T M L)) / 2.
GnssCorrelation TestGnssCorrelation(const FlightNetwork& network, const Marginals& marginals);

}  // namespace dn
