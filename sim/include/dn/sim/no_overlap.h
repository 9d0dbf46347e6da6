#pragma once

#include <dn/error.h>

namespace dn {

/// No two strips of a scenario that wants pairs see the same ground. Thrown by Simulate.
class NoOverlap : public InvalidConfig {
 public:
  using InvalidConfig::InvalidConfig;
};

}  // namespace dn
