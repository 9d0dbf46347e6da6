#pragma once

#include <cholmod.h>

#include <memory>

#include "sparse/block_pattern.h"

namespace dn::sparse {

/// CHOLMOD's workspace and settings, one object per thread. CHOLMOD prints nothing.
class CholmodCommon {
 public:
  CholmodCommon();
  ~CholmodCommon();
  CholmodCommon(const CholmodCommon&) = delete;
  CholmodCommon& operator=(const CholmodCommon&) = delete;

  cholmod_common* get() { return &common_; }
  cholmod_common* operator->() { return &common_; }

  /// Throws if the last CHOLMOD call failed; `step` names the operation in the message. The
  /// exception is std::bad_alloc, InvalidInput for a factor that is too large, or
  /// std::runtime_error.
  void Check(const char* step) const;

 private:
  cholmod_common common_;
};

struct FreeCholmodFactor {
  void operator()(cholmod_factor* factor) const noexcept;
};
using CholmodFactorPointer = std::unique_ptr<cholmod_factor, FreeCholmodFactor>;

/// Returns A as a CHOLMOD matrix without copying it, or only the pattern if A has no values.
cholmod_sparse View(const SymmetricCsc& A);

}  // namespace dn::sparse
