#pragma once

#include "supernode_tree.h"

namespace dn {

/// Computes X (L L^T)^-1 in place. X is k x n, column-major, so the k right-hand sides of an
/// unknown are contiguous. L is given by the pattern of its supernodes and their values.
void SolveInPlace(const SupernodalPattern& L, const double* values, int k, double* X);

/// Computes the first half, X L^-T, in place. Consecutive unknowns are `stride` numbers apart in X.
void SolveForwardInPlace(const SupernodalPattern& L, const double* values, int k, int stride,
                         double* X);

}  // namespace dn
