#pragma once

#include <dn/factors/lidar_effect.h>
#include <dn/files/flight.h>

#include <Eigen/Core>
#include <vector>

#include "hypothesis.h"

namespace dn::diagnosis_internal {

/// Derivatives of a pair's residual at one end, from which the models of effects are composed.
struct PairEnd {
  double t_s = 0.0;
  Eigen::Vector3d u_s;       ///< laser vector in the sensor frame, m
  Eigen::Matrix3d J_r_u;     ///< d residual / d laser vector in the sensor frame
  Eigen::Matrix3d J_r_a;     ///< d residual / d lever arm in body
  Eigen::Vector3d J_r_t;     ///< d residual / d tag of this end, for tag = t + dt
  Eigen::Matrix3d J_r_turn;  ///< d residual / d rotation vector of the boresight
};

struct PairEnds {
  FactorId factor = -1;
  PairEnd i, j;
};

/// Returns d residual / d effect through one end of a pair, for a lidar effect or a discrepancy of
/// laser vectors.
Eigen::MatrixXd EndColumns(const Hypothesis& hypothesis, const PairEnd& end);

/// Returns the columns of a lidar effect, or of a discrepancy of laser vectors, for these pairs.
EffectModel MakePairColumns(const Hypothesis& hypothesis, const std::vector<PairEnds>& pairs);

/// Returns the effects of a scanner whose mount does not move. Their remedies name the dynamic
/// network, because an adjustment on a fixed trajectory does not estimate them.
std::vector<Hypothesis> ScannerHypotheses(const Flight& flight);

/// Returns these effects with their columns for pairs.
Library MakeScannerHypotheses(const Flight& flight, const std::vector<PairEnds>& pairs);

}  // namespace dn::diagnosis_internal
