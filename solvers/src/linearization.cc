#include "linearization.h"

#include <dn/parallel.h>
#include <dn/solvers/robust_loss.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "factor_text.h"

namespace dn {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Number of rows stacked before each QR step of ProductTriangularFactor.
constexpr int kStackedRows = 2048;

}  // namespace

UnknownLayout::UnknownLayout(const Network& network) {
  std::vector<bool> used(AsSize(network.num_blocks()), false);
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    const FactorRecord& record = network.factor(id);
    if (!record.active) continue;
    for (const BlockId b : record.blocks) used[AsSize(b)] = true;
  }
  block_position.assign(AsSize(network.num_blocks()), -1);
  offset.push_back(0);
  for (BlockId b = 0; b < network.num_blocks(); ++b) {
    const BlockRecord& block = network.block(b);
    if (!used[AsSize(b)] || block.held) continue;
    block_position[AsSize(b)] = num_blocks();
    blocks.push_back(b);
    offset.push_back(offset.back() + block.kind.tangent_size);
  }
}

Linearization::Linearization(const Network& network, const UnknownLayout& layout, int threads)
    : Linearization(network, layout) {
  if (Evaluate(network, threads)) return;
  const auto undefined = std::find_if(edges_.begin(), edges_.end(),
                                      [](const Edge& edge) { return std::isnan(edge.rho); });
  throw InvalidInput("marginals: " + UndefinedFactorMessage(network, undefined->factor));
}

Linearization::Linearization(const Network& network, const UnknownLayout& layout)
    : layout_(layout) {
  Reserve(network);
}

bool Linearization::Evaluate(const Network& network, int threads) {
  ParallelFor(static_cast<int>(edges_.size()), threads,
              [&](int e) { EvaluateEdge(network, &edges_[AsSize(e)]); });
  return !std::isnan(cost());
}

double Linearization::cost() const {
  double sum = 0.0;
  for (const Edge& edge : edges_) sum += edge.rho;
  return 0.5 * sum;
}

Linearization::Linearization(const Linearization& other, const UnknownLayout& layout,
                             const Eigen::VectorXd& row_scale)
    : layout_(layout),
      edges_(other.edges_),
      positions_(other.positions_),
      values_(other.values_.size()),
      residual_(other.residual_.cwiseProduct(row_scale)) {
  for (const Edge& edge : edges_) {
    Eigen::Map<Eigen::MatrixXd> J(values_.data() + edge.data, edge.rows, edge.cols);
    J = row_scale.segment(edge.first_row, edge.rows).asDiagonal() * other.jacobian(edge);
  }
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
      const int position = layout_.block_position[AsSize(b)];
      if (position < 0) continue;
      positions_.push_back(position);
      edge.cols += layout_.block_size(position);
      ++edge.num_blocks;
    }
    size += AsSize(edge.rows) * AsSize(edge.cols);
    rows += edge.rows;
    edges_.push_back(edge);
  }
  values_.resize(size);
  residual_.resize(rows);
}

void Linearization::EvaluateEdge(const Network& network, Edge* edge) {
  const FactorRecord& record = network.factor(edge->factor);
  const std::size_t n = record.blocks.size();
  std::vector<const double*> x(n);
  std::vector<RowMajor> stored(n);
  std::vector<double*> J(n, nullptr);
  for (std::size_t i = 0; i < n; ++i) {
    const BlockRecord& block = network.block(record.blocks[i]);
    x[i] = block.value.get();
    if (block.held) continue;
    stored[i].resize(edge->rows, block.kind.stored_size);
    J[i] = stored[i].data();
  }
  auto r = residual_.segment(edge->first_row, edge->rows);
  const bool defined = network.EvaluateStored(edge->factor, x.data(), r.data(), J.data());

  Eigen::Map<Eigen::MatrixXd> out(values_.data() + edge->data, edge->rows, edge->cols);
  int column = 0;
  for (std::size_t i = 0; defined && i < n; ++i) {
    const BlockKind& kind = network.block(record.blocks[i]).kind;
    if (J[i] == nullptr) continue;
    StoredToTangent(kind, x[i], stored[i], out.middleCols(column, kind.tangent_size));
    column += kind.tangent_size;
  }
  if (!defined || !r.allFinite() || !out.allFinite()) {
    edge->rho = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  const LossValue loss = EvaluateLoss(record.loss, r.squaredNorm());
  edge->rho = loss.rho;
  edge->weight = loss.rho_prime;
  if (edge->weight != 1.0) {
    out *= std::sqrt(edge->weight);
    r *= std::sqrt(edge->weight);
  }
}

void Linearization::AddProduct(const Edge& edge, const Eigen::MatrixXd& X,
                               Eigen::Ref<Eigen::MatrixXd> out) const {
  const auto J = jacobian(edge);
  int column = 0;
  for (int i = 0; i < edge.num_blocks; ++i) {
    const int p = positions(edge)[i];
    const int size = layout_.block_size(p);
    out += J.middleCols(column, size).lazyProduct(X.middleRows(layout_.offset[AsSize(p)], size));
    column += size;
  }
}

Eigen::MatrixXd Linearization::TransposeTimes(const Eigen::MatrixXd& E) const {
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(layout_.size(), E.cols());
  for (const Edge& edge : edges_) {
    const auto J = jacobian(edge);
    int column = 0;
    for (int b = 0; b < edge.num_blocks; ++b) {
      const int p = positions(edge)[b];
      const int size = layout_.block_size(p);
      G.middleRows(layout_.offset[AsSize(p)], size) +=
          J.middleCols(column, size)
              .transpose()
              .lazyProduct(E.middleRows(edge.first_row, edge.rows));
      column += size;
    }
  }
  return G;
}

Eigen::MatrixXd Linearization::ProductTriangularFactor(const Eigen::MatrixXd& X) const {
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
    AddProduct(edge, X, product);
    for (int row = 0; row < edge.rows; ++row) {
      if (filled == stack.rows()) compress();
      stack.row(filled++) = product.row(row);
    }
  }
  compress();
  return stack.topRows(k);
}

}  // namespace dn
