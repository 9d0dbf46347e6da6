#pragma once

#include "supernode_tree.h"

namespace dn {

/// X (L L^T)^-1 in place. X: k x n, column-major: the k right-hand sides of an unknown stand
/// together. L: the pattern of its supernodes, and their values.
void SolveInPlace(const SupernodalPattern& L, const double* values, int k, double* X);

}  // namespace dn
