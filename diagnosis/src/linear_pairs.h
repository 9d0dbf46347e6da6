#pragma once

#include <dn/adjustment/gauss_helmert_flight.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "lidar_effects.h"
#include "time_correlated_errors.h"

namespace dn::diagnosis_internal {

/// The pairs kept by a Gauss-Helmert adjustment, linearised at its result and whitened.
struct LinearPairs {
  std::vector<PairRows> rows;
  /// Derivatives for the models of effects; `factor` is the index into rows.
  std::vector<PairEnds> ends;
  std::vector<Eigen::Matrix3d> whiten;  ///< whitening matrix of a misclosure in map, per m
  std::vector<std::size_t> pair;        ///< index into GaussHelmertProblem::pairs
  /// Square root of the stated covariance of an error of the trajectory: position in map (m),
  /// attitude in body (rad).
  Eigen::Matrix<double, 6, 6> error_sqrt = Eigen::Matrix<double, 6, 6>::Zero();
  BoresightPrior prior;
  /// Share of the pairs' own noise in the variance of a row, on average over the pairs. The rest is
  /// the stated error of the trajectory, taken as independent for every pair.
  double pair_noise_share = 1.0;
};

/// Returns the covariance, m^2, of a pair's misclosure in map. It has the pair's own noise, and
/// errors of the trajectory at both ends of `scale` times the stated size.
Eigen::Matrix3d MisclosureCovariance(const GaussHelmertPair& pair, const PairLinearisation& at,
                                     const ErrorScale& scale = {});

/// Returns the left rotation from the stated boresight to the estimated one.
Eigen::Vector3d DeviationFromPrior(const GaussHelmertCalibration& calibration);

/// Linearises the kept pairs; of more than 20000 pairs, every n-th. The boresight and the accuracy
/// of `calibration` must be set.
LinearPairs LinearisePairs(const Flight& flight, const GaussHelmertCalibration& calibration);

}  // namespace dn::diagnosis_internal
