#pragma once

#include <Eigen/Core>
#include <array>

namespace dn {

/// The derivative of a laser vector with respect to one of the LaserUnknowns.
struct LaserTerm {
  int unknown = -1;                                       ///< index of the unknown; -1: no term
  Eigen::Vector3d direction_b = Eigen::Vector3d::Zero();  ///< d u_b / d unknown, body frame, m/unit
};

/// Terms of one laser vector. The corrections of a beam are an angle and a range.
using LaserTerms = std::array<LaserTerm, 2>;

/// Unknowns x of the laser vectors besides the boresight, such as the corrections of the beams of a
/// scanner. With the terms of an end,
///
///   u_b(x) = u_b + sum_k direction_b,k (x_k - start_k)
///
/// so that the vectors and terms of a problem are those at `start`. The prior is Gaussian about
/// zero. A problem without such unknowns leaves both members empty.
struct LaserUnknowns {
  Eigen::VectorXd start;        ///< values at which the vectors are given
  Eigen::MatrixXd information;  ///< inverse covariance of the prior

  Eigen::Index size() const { return start.size(); }
};

/// Returns the change of a laser vector for a change of the unknowns.
inline Eigen::Vector3d VectorChange(const LaserTerms& terms, const Eigen::VectorXd& change) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const LaserTerm& term : terms) {
    if (term.unknown >= 0) sum += change[term.unknown] * term.direction_b;
  }
  return sum;
}

}  // namespace dn
