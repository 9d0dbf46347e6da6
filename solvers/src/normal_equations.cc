#include "normal_equations.h"

#include <dn/error.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dn {
namespace {

/// Scalar rows above each entry within its block column; the diagonal block is first.
std::vector<int> Heights(const UnknownLayout& layout, const SymmetricCsc& blocks) {
  std::vector<int> heights(blocks.row.size());
  for (int c = 0; c < blocks.n; ++c) {
    int height = 0;
    for (int e = blocks.column_start[AsSize(c)]; e < blocks.column_start[AsSize(c) + 1]; ++e) {
      heights[AsSize(e)] = height;
      height += layout.size_of(blocks.row[AsSize(e)]);
    }
  }
  return heights;
}

void AppendColumn(const UnknownLayout& layout, const SymmetricCsc& blocks, int c, int k,
                  SymmetricCsc* N) {
  for (int e = blocks.column_start[AsSize(c)]; e < blocks.column_start[AsSize(c) + 1]; ++e) {
    const int r = blocks.row[AsSize(e)];
    for (int i = r == c ? k : 0; i < layout.size_of(r); ++i) {
      N->row.push_back(layout.offset[AsSize(r)] + i);
    }
  }
  if (N->row.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw InvalidInput("marginals: the normal matrix has more than 2^31 entries");
  }
  N->column_start.push_back(static_cast<int>(N->row.size()));
}

SymmetricCsc ScalarPattern(const UnknownLayout& layout, const SymmetricCsc& blocks) {
  SymmetricCsc N;
  N.n = layout.size();
  N.column_start.assign(1, 0);
  for (int c = 0; c < blocks.n; ++c) {
    for (int k = 0; k < layout.size_of(c); ++k) AppendColumn(layout, blocks, c, k, &N);
  }
  return N;
}

/// Fills the scalar matrix block by block.
class Assembler {
 public:
  Assembler(const UnknownLayout& layout, const SymmetricCsc& blocks,
            const std::vector<int>& heights, SymmetricCsc* N)
      : layout_(layout), blocks_(blocks), heights_(heights), N_(*N) {
    N_.value.assign(N_.row.size(), 0.0);
  }

  /// Adds the block (row position, column position), row >= column.
  template <class Matrix>
  void Add(int row, int column, const Eigen::MatrixBase<Matrix>& block) {
    const auto begin = blocks_.row.begin() + blocks_.column_start[AsSize(column)];
    const auto end = blocks_.row.begin() + blocks_.column_start[AsSize(column) + 1];
    const int height =
        heights_[AsSize(static_cast<int>(std::lower_bound(begin, end, row) - blocks_.row.begin()))];
    for (int k = 0; k < block.cols(); ++k) {
      const int start = N_.column_start[AsSize(layout_.offset[AsSize(column)] + k)] + height - k;
      for (int i = row == column ? k : 0; i < block.rows(); ++i) {
        N_.value[AsSize(start + i)] += block(i, k);
      }
    }
  }

 private:
  const UnknownLayout& layout_;
  const SymmetricCsc& blocks_;
  const std::vector<int>& heights_;
  SymmetricCsc& N_;
};

}  // namespace

NormalEquations::NormalEquations(const UnknownLayout& layout, const Linearization& linearization)
    : blocks(BlockPattern(layout, linearization)), height_(Heights(layout, blocks)) {
  N = ScalarPattern(layout, blocks);
  Assemble(layout, linearization, Eigen::VectorXd::Ones(linearization.residual().size()));
}

void NormalEquations::Assemble(const UnknownLayout& layout, const Linearization& linearization,
                               const Eigen::VectorXd& row_weight) {
  Assembler assembler(layout, blocks, height_, &N);
  Eigen::MatrixXd weighted, product;
  for (const Linearization::Edge& edge : linearization.edges()) {
    const auto J = linearization.jacobian(edge);
    weighted.noalias() = row_weight.segment(edge.first_row, edge.rows).asDiagonal() * J;
    product.noalias() = J.transpose() * weighted;
    const int* position = linearization.positions(edge);
    int row = 0;
    for (int a = 0; a < edge.num_blocks; ++a) {
      const int rows = layout.size_of(position[a]);
      int column = 0;
      for (int b = 0; b < edge.num_blocks; ++b) {
        const int columns = layout.size_of(position[b]);
        if (position[a] >= position[b]) {
          assembler.Add(position[a], position[b], product.block(row, column, rows, columns));
        }
        column += columns;
      }
      row += rows;
    }
  }
}

Eigen::VectorXd JacobiScale(const SymmetricCsc& N) {
  Eigen::VectorXd scale(N.n);
  for (int c = 0; c < N.n; ++c) {
    const double diagonal = N.value[AsSize(N.column_start[AsSize(c)])];
    scale[c] = diagonal > 0.0 ? 1.0 / std::sqrt(diagonal) : 1.0;
  }
  return scale;
}

void ApplyScale(const Eigen::VectorXd& scale, SymmetricCsc* N) {
  for (int c = 0; c < N->n; ++c) {
    const auto begin = AsSize(N->column_start[AsSize(c)]);
    const auto end = AsSize(N->column_start[AsSize(c) + 1]);
    for (std::size_t e = begin; e < end; ++e) N->value[e] *= scale[c] * scale[N->row[e]];
  }
}

}  // namespace dn
