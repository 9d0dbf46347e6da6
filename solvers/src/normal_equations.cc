#include "normal_equations.h"

#include <dn/error.h>

#include <algorithm>
#include <cstdint>
#include <limits>

namespace dn {
namespace {

std::size_t Index(int i) { return static_cast<std::size_t>(i); }

/// The sorted, distinct (column, row) pairs of blocks with row >= column.
std::vector<std::uint64_t> BlockPairs(const Linearization& linearization) {
  std::vector<std::uint64_t> pairs;
  for (const Linearization::Edge& edge : linearization.edges()) {
    const int* position = linearization.positions(edge);
    for (int a = 0; a < edge.num_blocks; ++a) {
      for (int b = 0; b < edge.num_blocks; ++b) {
        if (position[a] < position[b]) continue;
        pairs.push_back(static_cast<std::uint64_t>(position[b]) << 32 |
                        static_cast<std::uint64_t>(position[a]));
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

SymmetricCsc BlockPattern(int num_blocks, const std::vector<std::uint64_t>& pairs) {
  SymmetricCsc pattern;
  pattern.n = num_blocks;
  pattern.column_start.assign(Index(num_blocks) + 1, 0);
  pattern.row.reserve(pairs.size());
  for (const std::uint64_t pair : pairs) {
    ++pattern.column_start[(pair >> 32) + 1];
    pattern.row.push_back(static_cast<int>(pair & 0xffffffffU));
  }
  for (std::size_t c = 1; c < pattern.column_start.size(); ++c) {
    pattern.column_start[c] += pattern.column_start[c - 1];
  }
  return pattern;
}

/// Fills the scalar matrix block by block.
class Assembler {
 public:
  Assembler(const UnknownLayout& layout, const SymmetricCsc& blocks, SymmetricCsc* N)
      : layout_(layout), blocks_(blocks), N_(*N) {
    FindHeights();
    FillPattern();
  }

  /// Adds the block (row position, column position), row >= column.
  template <class Matrix>
  void Add(int row, int column, const Eigen::MatrixBase<Matrix>& block) {
    const auto begin = blocks_.row.begin() + blocks_.column_start[Index(column)];
    const auto end = blocks_.row.begin() + blocks_.column_start[Index(column) + 1];
    const int height =
        height_[Index(static_cast<int>(std::lower_bound(begin, end, row) - blocks_.row.begin()))];
    for (int k = 0; k < block.cols(); ++k) {
      const int start = N_.column_start[Index(layout_.offset[Index(column)] + k)] + height - k;
      for (int i = row == column ? k : 0; i < block.rows(); ++i) {
        N_.value[Index(start + i)] += block(i, k);
      }
    }
  }

 private:
  /// height_[e]: scalar rows above entry e within its block column; the diagonal block is first.
  void FindHeights() {
    height_.resize(blocks_.row.size());

    for (int c = 0; c < blocks_.n; ++c) {
      int height = 0;
      for (int e = blocks_.column_start[Index(c)]; e < blocks_.column_start[Index(c) + 1]; ++e) {
        height_[Index(e)] = height;
        height += layout_.size_of(blocks_.row[Index(e)]);
      }
    }
  }

  void FillPattern() {
    N_.n = layout_.size();
    N_.column_start.assign(1, 0);
    for (int c = 0; c < blocks_.n; ++c) {
      for (int k = 0; k < layout_.size_of(c); ++k) AppendColumn(c, k);
    }
    N_.value.assign(N_.row.size(), 0.0);
  }

  void AppendColumn(int c, int k) {
    for (int e = blocks_.column_start[Index(c)]; e < blocks_.column_start[Index(c) + 1]; ++e) {
      const int r = blocks_.row[Index(e)];
      for (int i = r == c ? k : 0; i < layout_.size_of(r); ++i) {
        N_.row.push_back(layout_.offset[Index(r)] + i);
      }
    }
    if (N_.row.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
      throw InvalidInput("marginals: the normal matrix has more than 2^31 entries");
    }
    N_.column_start.push_back(static_cast<int>(N_.row.size()));
  }

  const UnknownLayout& layout_;
  const SymmetricCsc& blocks_;
  SymmetricCsc& N_;
  std::vector<int> height_;
};

}  // namespace

NormalEquations::NormalEquations(const UnknownLayout& layout, const Linearization& linearization)
    : blocks(BlockPattern(layout.num_blocks(), BlockPairs(linearization))) {
  Assembler assembler(layout, blocks, &N);
  Eigen::MatrixXd product;
  for (const Linearization::Edge& edge : linearization.edges()) {
    const auto J = linearization.jacobian(edge);
    product.noalias() = J.transpose() * J;
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

}  // namespace dn
