#pragma once

#include <dn/block.h>

#include <Eigen/Core>

namespace dn::factors_internal {

/// Returns the kind of a vector whose size is known only at run time.
inline BlockKind VectorKind(Eigen::Index size) {
  const int n = static_cast<int>(size);
  return {Parametrisation::kVector, n, n};
}

}  // namespace dn::factors_internal
