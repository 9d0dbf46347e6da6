#pragma once

#include <dn/files/flight_config.h>
#include <dn/network.h>

namespace dn::adjustment_internal {

/// Returns the loss that the configuration names, with the width of `usual`; returns `usual` if it
/// names none.
inline Loss ConfiguredLoss(RobustKind configured, const Loss& usual) {
  switch (configured) {
    case RobustKind::kHuber:
      return {Loss::Type::kHuber, usual.width};
    case RobustKind::kCauchy:
      return {Loss::Type::kCauchy, usual.width};
    case RobustKind::kNone:
      break;
  }
  return usual;
}

}  // namespace dn::adjustment_internal
