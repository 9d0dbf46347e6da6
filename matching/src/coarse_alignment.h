#pragma once

#include <dn/fixed_trajectory/gauss_helmert.h>
#include <dn/matching/match.h>

#include <Eigen/Core>
#include <vector>

namespace dn::matching_internal {

/// Points that a coarse level takes for the same point of the ground.
struct CoarsePair {
  std::size_t strip_i = 0, strip_j = 0;
  double t_i_s = 0.0, t_j_s = 0.0;
  Eigen::Vector3d x_i = Eigen::Vector3d::Zero();  ///< in the form of RawPoints::x
  Eigen::Vector3d x_j = Eigen::Vector3d::Zero();
  Eigen::Vector3d difference_m = Eigen::Vector3d::Zero();  ///< p_i - p_j with the present alignment
};

/// The residuals of an alignment.
struct AlignmentFit {
  std::size_t agreeing = 0;
  double rms_m = 0.0;  ///< of the differences of agreeing pairs, all three axes
};

/// Returns one end of a pair for a Gauss-Helmert adjustment, with the pose of the source and the
/// trajectory sigmas of the options. u_s: laser vector in the sensor frame, m.
GaussHelmertEnd MakeMatchEnd(const FlightMatchSource& source, double t_s,
                             const Eigen::Vector3d& u_s, const MatchOptions& options);

/// Turns the boresight so that most pairs agree within tolerance_m. The candidates are many
/// boresights from two random pairs each; the pairs that agree with the best one enter a
/// Gauss-Helmert adjustment. A prior with sigma search_rad about the initial boresight determines
/// the directions that the pairs leave undetermined.
AlignmentFit AlignBoresight(const std::vector<CoarsePair>& pairs,
                            const Eigen::Vector3d& given_boresight_rad, double tolerance_m,
                            const MatchOptions& options, FlightMatchSource* source);

/// Turns the boresights of some scanners so that most pairs agree within tolerance_m; those of the
/// others stay. The candidates are those of AlignBoresight. Least squares of the agreeing pairs
/// follow, with a prior of the standard deviation search_rad about the present boresights.
AlignmentFit AlignScanners(const std::vector<CoarsePair>& pairs,
                           const std::vector<std::size_t>& scanners, double tolerance_m,
                           const MatchOptions& options, ScannersMatchSource* source);

/// Shifts each strip after the first by the shift with which most pairs agree.
AlignmentFit AlignShifts(const std::vector<CoarsePair>& pairs, double tolerance_m,
                         BareMatchSource* source);

}  // namespace dn::matching_internal
