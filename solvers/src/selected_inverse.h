#pragma once

#include <optional>
#include <vector>

#include "sparse_cholesky.h"

namespace dn {

/// The entries of Z = (L L^T)^-1 within the pattern of the supernodal factor L.
///
///   Z_RJ = -Z_RR Y,   Z_JJ = L_JJ^-T L_JJ^-1 - Y^T Z_RJ,   Y = L_RJ L_JJ^-1
///
/// from the last supernode J to the first; R: the rows of J below its columns.
/// Source: Takahashi, Fagan and Chen (1973), taken by supernodes.
class SelectedInverse {
 public:
  explicit SelectedInverse(const SparseCholesky& cholesky);

  /// Entry (i, j) in the order of L; nothing outside its pattern.
  std::optional<double> At(int i, int j) const;

 private:
  class Recursion;

  SupernodalView L_;
  std::vector<int> supernode_of_column_;
  std::vector<double> value_;
};

}  // namespace dn
