#pragma once

#include <dn/builder/flight_network.h>

#include <Eigen/Core>
#include <vector>

namespace dn::internal {

/// First columns of PairColumns.
inline constexpr Eigen::Index kLeverArmColumn = 0, kTimeOffsetColumn = 3, kPairEffectsColumn = 4;

/// Returns the derivatives of the pair residuals as columns. They are those by the lidar's lever
/// arm, by its time offset, and by the effects of a calibration (PairEffectIndices), in this order.
///
/// There is one matrix per pair edge. It is empty for an inactive edge, and for one whose residual
/// is not a difference of two points. `means` are averaged samples for the derivatives of the
/// increments (AverageSamples). `whole` has, for each inertial edge that pairs use, the derivatives
/// of its rotation increment by the inertial effects.
std::vector<Eigen::Matrix3Xd> PairColumns(const FlightNetwork& network,
                                          const CalibrationState& calibration, const ImuData& means,
                                          const std::vector<Eigen::Matrix3Xd>& whole, int threads);

}  // namespace dn::internal
