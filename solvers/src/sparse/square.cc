#include "sparse/square.h"

#include "sparse/blas.h"

namespace dn::sparse {

void Square(int n, int k, const double* W, double* result) {
  dsyrk_("L", "N", &n, &k, &kOne, W, &n, &kZero, result, &n);
}

}  // namespace dn::sparse
