#pragma once

namespace dn::sparse {

/// Computes the lower triangle of W W^T by BLAS. W is n x k and the result is n x n, both
/// column-major and contiguous.
void Square(int n, int k, const double* W, double* result);

}  // namespace dn::sparse
