#pragma once

#include <dn/builder/flight_network.h>

#include <Eigen/Core>
#include <vector>

namespace dn::internal {

/// First columns of PairColumns.
inline constexpr Eigen::Index kColumnOfLeverArm = 0, kColumnOfTimeOffset = 3,
                              kColumnOfPairEffects = 4;

/// What the lidar's lever arm, its time offset and the values of a calibration's effects
/// (EffectsOfPairs) do to the residuals of pairs.
///
/// Returns d residual / d value of every pair edge, lever arm, time offset and effects side by side;
/// none of an edge that is not active, or whose residual is no difference of two points. `means`: samples over which the
/// increments stand for their derivatives (MeansOver); `whole`: of every inertial edge over which
/// pairs are bridged, the derivatives of its rotation increment by the inertial effects.
std::vector<Eigen::Matrix3Xd> PairColumns(const FlightNetwork& network,
                                          const CalibrationState& calibration, const ImuData& means,
                                          const std::vector<Eigen::Matrix3Xd>& whole, int threads);

}  // namespace dn::internal
