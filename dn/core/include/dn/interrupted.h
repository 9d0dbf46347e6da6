#pragma once

#include <dn/error.h>

namespace dn {

/// Thrown if the user stopped the work.
class Interrupted : public Error {
 public:
  Interrupted() : Error("interrupted") {}
};

}  // namespace dn
