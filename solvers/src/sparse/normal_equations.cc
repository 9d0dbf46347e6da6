#include "sparse/normal_equations.h"

#include <dn/error.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dn::sparse {
namespace {

/// Returns the number of scalar rows above each entry within its block column; the diagonal block
/// is first.
std::vector<int> Heights(const UnknownLayout& layout, const SymmetricCsc& blocks) {
  std::vector<int> heights(blocks.row.size());
  for (int c = 0; c < blocks.n; ++c) {
    int height = 0;
    for (int e = blocks.column_start[AsSize(c)]; e < blocks.column_start[AsSize(c) + 1]; ++e) {
      heights[AsSize(e)] = height;
      height += layout.block_size(blocks.row[AsSize(e)]);
    }
  }
  return heights;
}

void AppendColumn(const UnknownLayout& layout, const SymmetricCsc& blocks, int c, int k,
                  SymmetricCsc* N) {
  for (int e = blocks.column_start[AsSize(c)]; e < blocks.column_start[AsSize(c) + 1]; ++e) {
    const int r = blocks.row[AsSize(e)];
    for (int i = r == c ? k : 0; i < layout.block_size(r); ++i) {
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
    for (int k = 0; k < layout.block_size(c); ++k) AppendColumn(layout, blocks, c, k, &N);
  }
  return N;
}

}  // namespace

NormalEquations::NormalEquations(const UnknownLayout& layout, const Linearization& linearization)
    : blocks(BlockPattern(layout, linearization)), height_(Heights(layout, blocks)) {
  N = ScalarPattern(layout, blocks);
  (void)Place(linearization);
  Assemble(layout, linearization);
}

bool NormalEquations::Place(const Linearization& linearization) {
  places_.clear();
  for (const Linearization::Edge& edge : linearization.edges()) {
    const int* position = linearization.positions(edge);
    for (int b = 0; b < edge.num_blocks; ++b) {
      const auto begin = blocks.row.begin() + blocks.column_start[AsSize(position[b])];
      const auto end = blocks.row.begin() + blocks.column_start[AsSize(position[b]) + 1];
      for (int a = 0; a < edge.num_blocks; ++a) {
        if (position[a] < position[b]) continue;
        const auto found = std::lower_bound(begin, end, position[a]);
        if (found == end || *found != position[a]) return false;
        places_.push_back(height_[AsSize(static_cast<int>(found - blocks.row.begin()))]);
      }
    }
  }
  return true;
}

template <class Product>
void NormalEquations::Sum(const UnknownLayout& layout, const Linearization& linearization,
                          const Product& product_of) {
  N.value.assign(N.row.size(), 0.0);
  Eigen::MatrixXd product;
  const int* height = places_.data();
  for (const Linearization::Edge& edge : linearization.edges()) {
    product_of(edge, linearization.jacobian(edge), &product);
    const int* position = linearization.positions(edge);
    int column = 0;
    for (int b = 0; b < edge.num_blocks; ++b) {
      int row = 0;
      for (int a = 0; a < edge.num_blocks; ++a) {
        if (position[a] >= position[b]) {
          Add(layout, position[a], position[b], *height++, product, row, column);
        }
        row += layout.block_size(position[a]);
      }
      column += layout.block_size(position[b]);
    }
  }
}

void NormalEquations::Add(const UnknownLayout& layout, int a, int b, int height,
                          const Eigen::MatrixXd& product, int row, int column) {
  const int rows = layout.block_size(a), columns = layout.block_size(b);
  for (int k = 0; k < columns; ++k) {
    double* to = N.value.data() + N.column_start[AsSize(layout.offset[AsSize(b)] + k)] + height - k;
    const double* from = &product(row, column + k);
    for (int i = a == b ? k : 0; i < rows; ++i) to[i] += from[i];
  }
}

void NormalEquations::Assemble(const UnknownLayout& layout, const Linearization& linearization) {
  Sum(layout, linearization, [](const Linearization::Edge&, const auto& J, auto* product) {
    product->noalias() = J.transpose() * J;
  });
}

void NormalEquations::Assemble(const UnknownLayout& layout, const Linearization& linearization,
                               const Eigen::VectorXd& row_weight) {
  Eigen::MatrixXd weighted;
  Sum(layout, linearization, [&](const Linearization::Edge& edge, const auto& J, auto* product) {
    weighted.noalias() = row_weight.segment(edge.first_row, edge.rows).asDiagonal() * J;
    product->noalias() = J.transpose() * weighted;
  });
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

}  // namespace dn::sparse
