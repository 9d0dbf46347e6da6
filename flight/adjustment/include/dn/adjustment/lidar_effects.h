#pragma once

#include <dn/calibration/candidate_effects.h>
#include <dn/factors/lidar_effect.h>
#include <dn/flight/flight.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// What an effect is made of at one end of a pair.
struct PairEnd {
  double t_s = 0.0;
  Eigen::Vector3d u_s;       ///< laser vector in the sensor frame, m
  Eigen::Matrix3d J_r_u;     ///< d residual / d laser vector in the sensor frame
  Eigen::Matrix3d J_r_a;     ///< d residual / d lever arm in body
  Eigen::Vector3d J_r_t;     ///< d residual / d tag: of a late tag of this end (tag = t + dt)
  Eigen::Matrix3d J_r_turn;  ///< d residual / d rotation vector of the boresight
};

struct PairEnds {
  FactorId factor = -1;
  PairEnd i, j;
};

/// What an effect of the lidar, of the estimator's or one's own, does to these pairs.
CandidateEffect OnPairs(const EstimableEffect& effect, const Flight& flight,
                        const std::vector<PairEnds>& pairs);
CandidateEffect OnPairs(const OwnEffect& own, const std::vector<PairEnds>& pairs);

/// The effects of a scanner whose mount stands still. What estimates them is not the adjustment of
/// these pairs.
std::vector<CandidateEffect> EffectsOfScanner(const Flight& flight,
                                              const std::vector<PairEnds>& pairs);

}  // namespace dn
