#pragma once

#include <dn/flight/flight_config.h>
#include <dn/network.h>

namespace dn::internal {

/// The loss that a configuration asks for, or else `usual`.
inline Loss LossOf(RobustKind configured, const Loss& usual) {
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

}  // namespace dn::internal
