#pragma once

#include <dn/builder/flight_network.h>
#include <dn/gnss/gnss_process.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>

namespace dn {

/// Result of a test for time-correlated errors of the GNSS positions that the network does not
/// model. The vectors are in local east, north, up.
struct GnssCorrelation {
  Eigen::Vector3d lag1 = Eigen::Vector3d::Zero();  ///< correlation of successive residuals
  /// Expected value if all errors are modelled.
  Eigen::Vector3d lag1_expected = Eigen::Vector3d::Zero();
  /// p-values corrected for the family of tests: every axis, all axes together, and all correlation
  /// times.
  Eigen::Vector3d p_value = Eigen::Vector3d::Ones();
  double p_value_together = 1.0;
  GnssProcess process;  ///< the process that fits best; its sigmas are zero if no process fits

  /// Returns whether the test is significant at the level 0.001 per flight.
  bool significant() const;
};

/// Tests for a Gauss-Markov process on each axis with score tests. The correlation times tau go
/// from two epochs to a fifth of the flight. Let y = L^T r, where L is the derivative of the
/// whitened residuals r with respect to an error along the axis. Let K(tau) be the correlation
/// matrix of the process at the epochs. The statistic
///
///   T = y^T K y / E[y^T K y] / (y^T y / E[y^T y])
///
/// of one axis, or its sum over the axes, is approximated by a chi-square variable. Its moments are
/// those over samples of the residuals of the network if its model is true
/// (ForEachSampledResidual). The samples include the part of an error that the trajectory absorbs.
/// White noise larger than stated does not cause an alarm, because the statistic is divided by y^T
/// y.
///
/// `process` is the process whose expected energies y^T K y at all tau are nearest to those of the
/// data. It is a proposal, accurate to a factor of two in sigma^2 / tau.
///
/// `marginals` must belong to the INS/GNSS network at its solution, because errors of lidar pairs
/// would distort the trajectory. Flights with fewer than 20 active positions are not tested.
///
/// Source: Rao's score for a variance component at zero, u = (||L^T r||^2 - tr(L^T M L)) / 2.
GnssCorrelation TestGnssCorrelation(const FlightNetwork& network, const Marginals& marginals);

}  // namespace dn
