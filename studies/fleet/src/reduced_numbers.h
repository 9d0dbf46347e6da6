#pragma once

#include <dn/report/json_reader.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace dn::fleet_internal {

/// Largest number in reduced.json.
inline constexpr double kLargestNumber = 1e12;

/// Reads a number of reduced.json.
inline double ReadNumber(const JsonPlace& place) {
  return place.Number(-kLargestNumber, kLargestNumber);
}

/// Throws InvalidInput if a matrix is not positive definite.
inline void ExpectCovariance(const Eigen::MatrixXd& C, const JsonPlace& place) {
  const Eigen::VectorXd per_sigma = C.diagonal().cwiseMax(0.0).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd unit = per_sigma.asDiagonal() * C * per_sigma.asDiagonal();
  if (!unit.allFinite() || Eigen::LLT<Eigen::MatrixXd>(unit).info() != Eigen::Success) {
    place.Fail("is not a covariance matrix: it must be positive definite");
  }
}

}  // namespace dn::fleet_internal
