#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "sparse/cholesky.h"

namespace dn::sparse {

/// Entries of Z = (L L^T)^-1 within the pattern of the supernodal factor L:
///
///   Z_RJ = -Z_RR Y,   Z_JJ = L_JJ^-T L_JJ^-1 - Y^T Z_RJ,   Y = L_RJ L_JJ^-1
///
/// evaluated from the last supernode J to the first; R are the rows of J below its columns. Source:
/// Takahashi, Fagan and Chen (1973), in supernodal form.
class SelectedInverse {
 public:
  /// Computes the entries. The factor must outlive this object. The result does not depend on the
  /// number of threads. Throws std::bad_alloc.
  SelectedInverse(const Cholesky& cholesky, int threads);

  /// Returns entry (i, j) in the order of L, or nullopt outside its pattern.
  std::optional<double> At(int i, int j) const;

  /// Gathers the entries of all pairs of `indices`, in the order of L. Returns false if one is
  /// outside the pattern.
  bool Gather(const std::vector<int>& indices, Eigen::MatrixXd* Z) const;

 private:
  class Step;

  double* Z(int s);
  const double* ColumnData(int s, int column) const;

  const Cholesky& cholesky_;
  std::unique_ptr<double[]> value_;
};

}  // namespace dn::sparse
