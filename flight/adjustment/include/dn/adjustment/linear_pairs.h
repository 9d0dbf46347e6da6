#pragma once

#include <dn/calibration/gauss_helmert_flight.h>
#include <dn/calibration/lasting_errors.h>
#include <dn/calibration/lidar_effects.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace dn {

/// The pairs that a Gauss-Helmert adjustment has kept, linear at its result and whitened.
struct LinearPairs {
  std::vector<PairRows> rows;
  std::vector<PairEnds> ends;  ///< what effects are made of; the factor is the place in rows
  std::vector<Eigen::Matrix3d> whiten;  ///< takes a misclosure in map, m, to the rows' unit
  std::vector<std::size_t> pair;        ///< of GaussHelmertProblem::pairs
  /// Square root of the stated covariance of an error of the trajectory: position in map (m),
  /// attitude in body (rad).
  Eigen::Matrix<double, 6, 6> error_sqrt = Eigen::Matrix<double, 6, 6>::Zero();
  BoresightPrior prior;
  /// Of the noise of a row, the share of its variance that is the pairs' own; the rest is the stated
  /// error of the trajectory, as if it were new in every pair. Mean over the pairs.
  double share_of_pairs = 1.0;
};

/// Covariance of a pair's misclosure in map by its own noise and by errors of the trajectory at both
/// ends of `scale` times the stated size, m^2.
Eigen::Matrix3d MisclosureCovariance(const GaussHelmertPair& pair, const PairLinearisation& at,
                                     const ErrorScale& scale = {});

/// Of more than 20000 pairs a part, evenly. `calibration` has its boresight and accuracy.
LinearPairs LinearisePairs(const Flight& flight, const GaussHelmertCalibration& calibration);

}  // namespace dn
