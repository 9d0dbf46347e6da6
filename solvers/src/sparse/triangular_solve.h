#pragma once

#include "sparse/supernode_tree.h"

namespace dn::sparse {

/// Computes X (L L^T)^-1 in place. X is k x n, column-major, so the k right-hand sides of an
/// unknown are contiguous; consecutive unknowns are `stride` numbers apart. L is given by the
/// pattern of its supernodes and their values.
void SolveBothWays(const SupernodalPattern& L, const double* values, int k, int stride, double* X);

/// Computes the first half, X L^-T, in place.
void SolveForwards(const SupernodalPattern& L, const double* values, int k, int stride, double* X);

}  // namespace dn::sparse
