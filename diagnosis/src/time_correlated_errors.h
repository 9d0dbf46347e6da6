#pragma once

#include <dn/files/flight_config.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <cmath>
#include <compare>
#include <vector>

namespace dn::diagnosis_internal {

/// Linearised, whitened misclosure of a pair:
///
///   r = w + A dtheta + B_i e(t_i) + B_j e(t_j),    e: position in map (m), attitude in body (rad).
struct PairRows {
  double t_i_s = 0.0, t_j_s = 0.0;
  Eigen::Vector3d w;
  Eigen::Matrix3d A;
  Eigen::Matrix<double, 3, 6> B_i, B_j;
};

/// Prior of the boresight, in addition to the pairs, about the present values.
struct BoresightPrior {
  Eigen::Matrix3d weight = Eigen::Matrix3d::Zero();    ///< rad^-2
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< weight times (present - stated)
};

/// Scale factors of the stated errors of a flight.
struct ErrorScale {
  double position = 1.0;  ///< of the trajectory's position errors
  double attitude = 1.0;
  double white = 1.0;  ///< of the white noise of each pair
};

/// Largest scale of the trajectory errors, in octaves above the stated one.
inline constexpr int kMaxOctaves = 5;

/// Scale of the trajectory errors in octaves above the stated one.
struct ErrorOctaves {
  int position = 0, attitude = 0;

  auto operator<=>(const ErrorOctaves&) const = default;
  ErrorScale Scale(double white) const { return {std::exp2(position), std::exp2(attitude), white}; }
  /// Returns the log prior: a standard deviation of one octave above the stated scale.
  double LogPrior() const { return -0.5 * (position * position + attitude * attitude); }
};

/// The pairs of a flight with the boresight and the time-correlated errors of the trajectory as
/// unknowns. Each strip has a constant error, and an error that is linear between nodes in time.
/// Each of the two has half the stated variance. The errors of different strips are independent.
class TimeCorrelatedErrorModel {
 public:
  /// Each block has one part per row, in the order of `rows`. `strips` must not be empty.
  /// `error_sqrt` is a square root of the stated covariance of an error, position first.
  TimeCorrelatedErrorModel(const std::vector<PairRows>& rows,
                           const std::vector<StripInterval>& strips,
                           const Eigen::Matrix<double, 6, 6>& error_sqrt,
                           const BoresightPrior& prior, const std::vector<EffectModel>& blocks);

  /// Likelihood and scores for one scale of the errors.
  struct ScaleSolution {
    double log_likelihood = 0.0;  ///< without effects, up to a constant
    double chi2 = 0.0;            ///< weighted sum of squares at the solution, without effects
    /// Score of the blocks. Its shift is that of the Gauss-Helmert adjustment, which takes the
    /// trajectory as given.
    JointScore score;
  };
  /// Solves for errors of one scale. Dense: O(n^3) in the number n of unknowns.
  ScaleSolution At(const ErrorScale& scale) const;

  /// Returns the covariance, rad^2, of the boresight of the Gauss-Helmert adjustment under errors
  /// of one scale.
  Eigen::Matrix3d BoresightCovariance(const ErrorScale& scale) const;

  /// Returns the sum of squares with effects of this size (all components, SI) over that without
  /// effects; both without time-correlated errors.
  double ResidualShare(const Eigen::VectorXd& effects) const;

 private:
  Eigen::VectorXd UnknownScales(const ErrorScale& scale) const;
  Eigen::Matrix3d BoresightNormal() const;

  BoresightPrior prior_;
  double rows_ = 0.0;
  double rr_ = 0.0;  // w^T w
  // J^T w, L^T w; columns of J: boresight, then errors in units of their sigma.
  Eigen::VectorXd b_, Lr_;
  Eigen::MatrixXd H_, G_;  // J^T J, J^T L
  Eigen::MatrixXd LL_;     // L^T L
  std::vector<Eigen::Index> first_;
};

}  // namespace dn::diagnosis_internal
