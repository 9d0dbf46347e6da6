#pragma once

#include <stdexcept>

namespace dn {

/// Thrown if the user stopped the work.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

}  // namespace dn
