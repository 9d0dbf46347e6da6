#pragma once

#include <dn/builder/flight_network.h>

#include <Eigen/Core>
#include <vector>

namespace dn::diagnosis_internal {

/// Returns the derivatives of the pair residuals by the effects of a calibration as columns, in the
/// order of PairEffectIndices.
///
/// There is one matrix per pair edge. It is empty for an inactive edge, and for one whose residual
/// is not a difference of two points. `means` are averaged samples for the derivatives of the
/// increments (AverageSamples). `whole` has, for each inertial edge that pairs use, the derivatives
/// of its rotation increment by the inertial effects.
std::vector<Eigen::Matrix3Xd> PairColumns(const FlightNetwork& network,
                                          const CalibrationState& calibration, const ImuData& means,
                                          const std::vector<Eigen::Matrix3Xd>& whole, int threads);

}  // namespace dn::diagnosis_internal
