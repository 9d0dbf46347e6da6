#pragma once

#include <stdexcept>

namespace dn {

/// The work was stopped by its user.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

}  // namespace dn
