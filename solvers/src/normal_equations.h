#pragma once

#include <vector>

#include "block_pattern.h"

namespace dn {

/// N = J^T W J, with the pattern of its blocks beside it.
struct NormalEquations {
  SymmetricCsc N;
  SymmetricCsc blocks;  ///< pattern only: which blocks of the layout share a factor

  /// W = I.
  NormalEquations(const UnknownLayout& layout, const Linearization& linearization);

  /// The values of N anew, W = diag(row_weight).
  void Assemble(const UnknownLayout& layout, const Linearization& linearization,
                const Eigen::VectorXd& row_weight);

 private:
  std::vector<int> height_;  ///< scalar rows above each entry of blocks, within its block column
};

/// 1 / sqrt(N_ii); 1 for an unknown on which nothing depends.
Eigen::VectorXd JacobiScale(const SymmetricCsc& N);

/// diag(scale) N diag(scale).
void ApplyScale(const Eigen::VectorXd& scale, SymmetricCsc* N);

}  // namespace dn
