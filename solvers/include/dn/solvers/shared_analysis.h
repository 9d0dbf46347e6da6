#pragma once

#include <memory>

namespace dn {

/// The elimination order of networks with one structure, its symbolic analysis and the memory of
/// the normal equations, shared between solutions and covariances. If the next network connects
/// blocks that this one does not, the analysis is repeated. Must be used by one thread at a time.
class SharedAnalysis {
 public:
  struct Impl;

  SharedAnalysis();
  ~SharedAnalysis();
  SharedAnalysis(const SharedAnalysis&) = delete;
  SharedAnalysis& operator=(const SharedAnalysis&) = delete;

  /// Internal: only the sources of this layer use it.
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace dn
