#pragma once

#include <dn/imu/imu_data.h>

namespace dn {

/// The data with their samples joined into means over at most longest_s: for quantities that need no
/// more than what the vehicle does as a whole, as the derivatives of increments. Samples on either
/// side of a gap, and those that bridge a hole, are not joined with others; samples longer than
/// longest_s stay as they are. The increments over whole joined samples are those of the data but
/// for the coning and sculling within them.
ImuData MeansOver(const ImuData& imu, double longest_s);

}  // namespace dn
