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

  /// Makes ready for the edges of another linearisation of the layout. False where they tie blocks
  /// that the pattern does not.
  [[nodiscard]] bool Place(const Linearization& linearization);

  /// The values of N anew, W = I, for the edges that were placed last.
  void Assemble(const UnknownLayout& layout, const Linearization& linearization);
  /// W = diag(row_weight).
  void Assemble(const UnknownLayout& layout, const Linearization& linearization,
                const Eigen::VectorXd& row_weight);

 private:
  /// N as the sum of what product_of(edge, J, &product) makes of each edge.
  template <class Product>
  void Sum(const UnknownLayout& layout, const Linearization& linearization,
           const Product& product_of);
  /// Adds the part of a product from (row, column) on to block (a, b), which has so many rows above.
  void Add(const UnknownLayout& layout, int a, int b, int height, const Eigen::MatrixXd& product,
           int row, int column);

  std::vector<int> places_;  ///< heights of the blocks of all edges, one after the other
  std::vector<int> height_;  ///< scalar rows above each entry of blocks, within its block column
};

/// 1 / sqrt(N_ii); 1 for an unknown on which nothing depends.
Eigen::VectorXd JacobiScale(const SymmetricCsc& N);

/// diag(scale) N diag(scale).
void ApplyScale(const Eigen::VectorXd& scale, SymmetricCsc* N);

}  // namespace dn
