#pragma once

#include <memory>

namespace dn {

/// What solutions and covariances of networks of one structure have in common: the order in which
/// the unknowns are eliminated, its analysis, and room for the normal equations. Where the next
/// network ties blocks that this one does not, it is made anew. For one thread at a time.
class SharedAnalysis {
 public:
  struct Impl;

  SharedAnalysis();
  ~SharedAnalysis();
  SharedAnalysis(const SharedAnalysis&) = delete;
  SharedAnalysis& operator=(const SharedAnalysis&) = delete;

  /// For the sources of this layer.
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace dn
