#include "normal_equations.h"

#include <dn/parallel.h>
#include <dn/solvers/robust_loss.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "factor_text.h"

namespace dn {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Rows stacked before a QR step of TriangularFactorOfProduct.
constexpr int kStackedRows = 2048;

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

UnknownLayout::UnknownLayout(const Network& network) {
  std::vector<bool> used(Index(network.num_blocks()), false);
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    const FactorRecord& record = network.factor(id);
    if (!record.active) continue;
    for (const BlockId b : record.blocks) used[Index(b)] = true;
  }
  position_of.assign(Index(network.num_blocks()), -1);
  offset.push_back(0);
  for (BlockId b = 0; b < network.num_blocks(); ++b) {
    const BlockRecord& block = network.block(b);
    if (!used[Index(b)] || block.held) continue;
    position_of[Index(b)] = num_blocks();
    blocks.push_back(b);
    offset.push_back(offset.back() + block.kind.tangent_size);
  }
}

Linearization::Linearization(const Network& network, const UnknownLayout& layout, int threads)
    : layout_(layout) {
  Reserve(network);
  ParallelFor(static_cast<int>(edges_.size()), threads,
              [&](int e) { EvaluateEdge(network, edges_[Index(e)]); });
}

void Linearization::Reserve(const Network& network) {
  std::size_t size = 0;
  int rows = 0;
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    const FactorRecord& record = network.factor(id);
    if (!record.active) continue;
    Edge edge;
    edge.factor = id;
    edge.rows = record.factor->residual_size();
    edge.first_row = rows;
    edge.data = size;
    edge.first_block = positions_.size();
    for (const BlockId b : record.blocks) {
      const int position = layout_.position_of[Index(b)];
      if (position < 0) continue;
      positions_.push_back(position);
      edge.cols += layout_.size_of(position);
      ++edge.num_blocks;
    }
    if (edge.num_blocks == 0) continue;
    size += Index(edge.rows) * Index(edge.cols);
    rows += edge.rows;
    edges_.push_back(edge);
  }
  values_.resize(size);
  residual_.resize(rows);
}

void Linearization::EvaluateEdge(const Network& network, const Edge& edge) {
  const FactorRecord& record = network.factor(edge.factor);
  const std::size_t n = record.blocks.size();
  std::vector<const double*> x(n);
  std::vector<RowMajor> stored(n);
  std::vector<double*> J(n, nullptr);
  for (std::size_t i = 0; i < n; ++i) {
    const BlockRecord& block = network.block(record.blocks[i]);
    x[i] = block.value.get();
    if (block.held) continue;
    stored[i].resize(edge.rows, block.kind.stored_size);
    J[i] = stored[i].data();
  }
  Eigen::VectorXd r(edge.rows);
  const bool defined = network.EvaluateStored(edge.factor, x.data(), r.data(), J.data());

  Eigen::Map<Eigen::MatrixXd> out(values_.data() + edge.data, edge.rows, edge.cols);
  int column = 0;
  for (std::size_t i = 0; defined && i < n; ++i) {
    const BlockKind& kind = network.block(record.blocks[i]).kind;
    if (J[i] == nullptr) continue;
    StoredToTangent(kind, x[i], stored[i], out.middleCols(column, kind.tangent_size));
    column += kind.tangent_size;
  }
  if (!defined || !r.allFinite() || !out.allFinite()) {
    throw InvalidInput("marginals: " + UndefinedFactorMessage(network, edge.factor));
  }
  const double weight = EvaluateLoss(record.loss, r.squaredNorm()).rho_prime;
  if (weight != 1.0) {
    out *= std::sqrt(weight);
    r *= std::sqrt(weight);
  }
  residual_.segment(edge.first_row, edge.rows) = r;
}

Eigen::MatrixXd Linearization::TriangularFactorOfProduct(const Eigen::MatrixXd& X) const {
  const Eigen::Index k = X.cols();
  Eigen::MatrixXd stack = Eigen::MatrixXd::Zero(k + kStackedRows, k);
  Eigen::Index filled = k;
  const auto compress = [&] {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(stack.topRows(filled));
    const Eigen::MatrixXd R = qr.matrixQR().topRows(k).triangularView<Eigen::Upper>();
    stack.topRows(k) = R;
    filled = k;
  };
  for (const Edge& edge : edges_) {
    Eigen::MatrixXd product = Eigen::MatrixXd::Zero(edge.rows, k);
    const auto J = jacobian(edge);
    int column = 0;
    for (int i = 0; i < edge.num_blocks; ++i) {
      const int p = positions(edge)[i];
      const int size = layout_.size_of(p);
      product += J.middleCols(column, size) * X.middleRows(layout_.offset[Index(p)], size);
      column += size;
    }
    for (int row = 0; row < edge.rows; ++row) {
      if (filled == stack.rows()) compress();
      stack.row(filled++) = product.row(row);
    }
  }
  compress();
  return stack.topRows(k);
}

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
