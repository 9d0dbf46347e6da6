#pragma once

#include <dn/imu/imu_model.h>

namespace dn {

/// Value of imu.grade for a unit without data sheet, whose noise the data tell.
inline constexpr const char* kUnknownGrade = "unknown";

/// Returns the model from which the noise of an unknown unit is estimated. Its bias processes are
/// those of a MEMS unit; its random constants hold for all units.
ImuModel UnknownImu();

}  // namespace dn
