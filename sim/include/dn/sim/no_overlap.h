#pragma once

#include <dn/error.h>

namespace dn {

/// Error of a scenario that needs pairs although no two of its strips overlap. Thrown by Simulate.
class NoOverlap : public InvalidConfig {
 public:
  using InvalidConfig::InvalidConfig;
};

}  // namespace dn
