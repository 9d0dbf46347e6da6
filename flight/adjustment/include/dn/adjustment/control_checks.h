#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// A control point or plane against the prediction of all other data.
struct ControlPointCheck {
  enum class Role { kObservation, kCheck, kRejected };

  std::string name;
  std::string where;  ///< file:line
  Role role = Role::kObservation;
  /// Directions of the components below, unit vectors in local east, north, up: one column each.
  Eigen::Matrix<double, 3, Eigen::Dynamic> directions_enu;
  /// Position by the laser minus the surveyed one along the directions, m. The laser's position is
  /// that of all other data: without the survey of this point.
  Eigen::VectorXd residual_m;
  Eigen::MatrixXd covariance_m2;  ///< of the residual, with the survey's own
  Eigen::VectorXd survey_sigma_m;
  double statistic = 0.0;  ///< residual^T covariance^-1 residual
  int dof = 0;
  double p_value = 1.0;  ///< for the family of all control points
  /// Change of the boresight (left rotation) if an observation were left out; the influence of the
  /// point on it.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();

  bool vertical() const;    ///< whether the residual has a component up
  bool horizontal() const;  ///< whether it has the components east and north
  Eigen::VectorXd normalised() const {
    return residual_m.cwiseQuotient(covariance_m2.diagonal().cwiseSqrt());
  }
};

/// Returns "observation", "check" or "rejected".
const char* Word(ControlPointCheck::Role role);

/// A constant shift of the control against the GNSS positions, local east, north, up.
struct ControlShift {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  double statistic = 0.0;  ///< chi-square with three degrees of freedom without a shift
  double p_value = 1.0;    ///< of no shift; 1 for an estimated one
  bool estimated = false;  ///< true: an unknown of the network; false: it would improve the fit
};

/// Accuracy of the points by withheld checks, after the ASPRS Positional Accuracy Standards for
/// Digital Geospatial Data, edition 2.
struct ControlAccuracy {
  int checks = 0;       ///< checks with this component
  double mean_m = 0.0;  ///< of the height; 0 for the horizontal one
  double rmse_m = 0.0;  ///< of the residuals: RMSE_1 of the standard
  /// Accuracy of the checks themselves: RMSE_2 of the standard, from the sigmas of the survey.
  double survey_m = 0.0;

  double combined_m() const;  ///< root of the sum of squares: RMSE_V or RMSE_H of the standard
};

/// The control of an adjusted flight.
struct ControlCheck {
  std::vector<ControlPointCheck> points;
  std::optional<ControlShift> shift;
  std::optional<ControlAccuracy> vertical, horizontal;  ///< absent without checks
  /// Normalised sum of squares of all checks over their number of components; 1 is expected.
  std::optional<double> variance_of_checks;
  int check_components = 0;

  /// Returns the accuracies of the checks among the points.
  void ComputeAccuracy();
  /// Returns the observation that contradicts all other data most, if it is significant at `level`.
  const ControlPointCheck* Worst(double level) const;
};

}  // namespace dn
