#pragma once

#include <dn/imu/shaking.h>
#include <dn/report/json_fwd.h>

#include <optional>

namespace dn::apps {

/// Returns the figures of FindShaking; null without them.
Json ShakingJson(const std::optional<Shaking>& shaking);

/// Prints one line after `label`, unless the platform is calm or the figures are not available.
void PrintShaking(const std::optional<Shaking>& shaking, const char* label);

}  // namespace dn::apps
