#pragma once

#include <cholmod.h>

#include "block_pattern.h"

namespace dn {

/// What CHOLMOD keeps between its calls, one for each thread. It prints nothing.
class CholmodCommon {
 public:
  CholmodCommon();
  ~CholmodCommon();
  CholmodCommon(const CholmodCommon&) = delete;
  CholmodCommon& operator=(const CholmodCommon&) = delete;

  cholmod_common* get() { return &common_; }
  cholmod_common* operator->() { return &common_; }

  /// Throws std::bad_alloc, InvalidInput for a factor that is too large, or std::runtime_error,
  /// where the last call failed while doing `step`.
  void Check(const char* step) const;

 private:
  cholmod_common common_;
};

/// A as CHOLMOD sees it, without a copy; only its pattern where it has no values.
cholmod_sparse View(const SymmetricCsc& A);

}  // namespace dn
