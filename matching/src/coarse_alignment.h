#pragma once

#include <dn/matching/match.h>

#include <Eigen/Core>
#include <vector>

namespace dn::internal {

/// Points that are the same by a coarse stage.
struct CoarsePair {
  std::size_t strip_i = 0, strip_j = 0;
  double t_i_s = 0.0, t_j_s = 0.0;
  Eigen::Vector3d x_i = Eigen::Vector3d::Zero();  ///< RawPoints::x
  Eigen::Vector3d x_j = Eigen::Vector3d::Zero();
  Eigen::Vector3d difference_m = Eigen::Vector3d::Zero();  ///< p_i - p_j by the present alignment
};

/// What an alignment leaves.
struct AlignmentFit {
  std::size_t agreeing = 0;
  double rms_m = 0.0;  ///< of their differences, all three axes
};

/// Turns the boresight so that most pairs agree, to within tolerance_m: the best of many boresights
/// from two pairs each, then the Gauss-Helmert adjustment of the pairs that agree with it. A prior
/// of search_rad about the boresight that was given holds what the pairs leave free.
AlignmentFit AlignBoresight(const std::vector<CoarsePair>& pairs,
                            const Eigen::Vector3d& given_boresight_rad, double tolerance_m,
                            const MatchOptions& options, FlightMatchSource* source);

/// Shifts the strips after the first by the shift that most pairs agree with.
AlignmentFit AlignShifts(const std::vector<CoarsePair>& pairs, double tolerance_m,
                         BareMatchSource* source);

}  // namespace dn::internal
