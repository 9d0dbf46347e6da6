#pragma once

#include <vector>

#include "sparse/block_pattern.h"

namespace dn::sparse {

/// The normal matrix N = J^T W J and the pattern of its blocks.
struct NormalEquations {
  SymmetricCsc N;
  SymmetricCsc blocks;  ///< pattern without values: pairs of blocks that share a factor

  /// Builds the pattern and assembles N with W = I.
  NormalEquations(const UnknownLayout& layout, const Linearization& linearization);

  /// Prepares the assembly for another linearisation of the same layout. Returns false if its
  /// factors connect blocks outside the pattern.
  [[nodiscard]] bool Place(const Linearization& linearization);

  /// Assembles N again with W = I, for the edges of the last call of Place.
  void Assemble(const UnknownLayout& layout, const Linearization& linearization);
  /// Assembles N with W = diag(row_weight).
  void Assemble(const UnknownLayout& layout, const Linearization& linearization,
                const Eigen::VectorXd& row_weight);

 private:
  /// Assembles N as the sum of the matrices that product_of(edge, J, &product) computes for each
  /// edge.
  template <class Product>
  void Sum(const UnknownLayout& layout, const Linearization& linearization,
           const Product& product_of);
  /// Adds the part of `product` that starts at (row, column) to block (a, b), which has `height`
  /// scalar rows above it in its block column.
  void Add(const UnknownLayout& layout, int a, int b, int height, const Eigen::MatrixXd& product,
           int row, int column);

  std::vector<int> places_;  ///< heights of the blocks of all edges, in order
  std::vector<int> height_;  ///< scalar rows above each entry of `blocks`, within its block column
};

/// Returns 1 / sqrt(N_ii), or 1 for an unknown that does not affect any residual.
Eigen::VectorXd JacobiScale(const SymmetricCsc& N);

/// Replaces N by diag(scale) N diag(scale).
void ApplyScale(const Eigen::VectorXd& scale, SymmetricCsc* N);

}  // namespace dn::sparse
