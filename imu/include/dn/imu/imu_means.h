#pragma once

#include <dn/imu/imu_data.h>

namespace dn {

/// Returns the data with adjacent samples averaged over at most longest_s. This suffices for
/// quantities that depend only on the motion of the vehicle as a whole, such as derivatives of
/// increments. Samples across a gap and samples that bridge a hole are not averaged with others.
/// Samples longer than longest_s stay as they are. Increments over whole averaged samples equal
/// those of the data, except for coning and sculling within them.
ImuData AverageSamples(const ImuData& imu, double longest_s);

}  // namespace dn
