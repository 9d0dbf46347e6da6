#pragma once

#include "supernode_tree.h"

namespace dn {

/// X (L L^T)^-1 in place. X: k x n, column-major: the k right-hand sides of an unknown stand
/// together. L: the pattern of its supernodes, and their values.
void SolveInPlace(const SupernodalPattern& L, const double* values, int k, double* X);

/// The first half of it, X L^-T in place. The right-hand sides of the next unknown stand `stride`
/// numbers after those of an unknown.
void SolveForwardInPlace(const SupernodalPattern& L, const double* values, int k, int stride,
                         double* X);

}  // namespace dn
