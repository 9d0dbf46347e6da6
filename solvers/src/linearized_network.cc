#include <dn/error.h>
#include <dn/parallel.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "linearized_impl.h"

namespace dn {
namespace {

void ExpectRows(Eigen::Index rows, Eigen::Index expected, const char* what) {
  if (rows == expected) return;
  throw InvalidInput("linearised network: " + std::to_string(rows) + " rows for " +
                     std::to_string(expected) + " " + what);
}

}  // namespace

LinearizedNetwork::Impl::Impl(const Network& network, int num_threads)
    : threads(num_threads),
      layout(network),
      linearization(network, layout, threads),
      row_scale(Eigen::VectorXd::Ones(linearization.residual().size())),
      groups(network.groups()) {
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    const FactorRecord& record = network.factor(id);
    factors.push_back({-1, record.group, record.t_s});
    if (!record.active && record.factor) idle[id] = {record.factor, record.blocks};
  }
  for (const Linearization::Edge& edge : linearization.edges()) {
    factors[static_cast<std::size_t>(edge.factor)].edge = static_cast<int>(factor_rows.size());
    factor_rows.push_back({edge.factor, edge.first_row, edge.rows, edge.weight});
  }
  for (BlockId b = 0; b < network.num_blocks(); ++b) {
    const BlockRecord& block = network.block(b);
    blocks.push_back(
        {block.name, block.kind, block.held, block.label, values.size(), block.network});
    values.insert(values.end(), block.value.get(), block.value.get() + block.kind.stored_size);
  }
}

LinearizedNetwork::Impl::Impl(const Impl& other, const Eigen::VectorXd& scale)
    : threads(other.threads),
      layout(other.layout),
      linearization(other.linearization, layout, scale),
      row_scale(other.row_scale.cwiseProduct(scale)),
      factor_rows(other.factor_rows),
      factors(other.factors),
      idle(other.idle),
      groups(other.groups),
      blocks(other.blocks),
      values(other.values) {}

const LinearizedNetwork::Impl::BlockInfo& LinearizedNetwork::Impl::block(BlockId b) const {
  if (b < 0 || b >= static_cast<int>(blocks.size())) {
    throw InvalidInput("linearised network: no block with id " + std::to_string(b));
  }
  return blocks[static_cast<std::size_t>(b)];
}

const LinearizedNetwork::Impl::FactorInfo& LinearizedNetwork::Impl::factor(FactorId id) const {
  if (id < 0 || id >= static_cast<int>(factors.size())) {
    throw InvalidInput("linearised network: no factor with id " + std::to_string(id));
  }
  return factors[static_cast<std::size_t>(id)];
}

const LinearizedNetwork::Impl::IdleFactor& LinearizedNetwork::Impl::idle_factor(FactorId id) const {
  const auto found = idle.find(id);
  if (found == idle.end()) {
    throw InvalidInput("linearised network: factor " + std::to_string(id) + " was removed");
  }
  return found->second;
}

int LinearizedNetwork::Impl::residual_size(FactorId id) const {
  const int edge = factor(id).edge;
  return edge >= 0 ? factor_rows[static_cast<std::size_t>(edge)].count
                   : idle_factor(id).factor->residual_size();
}

LinearizedNetwork::Factor LinearizedNetwork::Impl::ActiveFactor(
    const Linearization::Edge& edge) const {
  Factor factor;
  factor.weight = edge.weight;
  const double per_row = edge.weight > 0.0 ? 1.0 / std::sqrt(edge.weight) : 0.0;
  factor.residual = per_row * linearization.residual().segment(edge.first_row, edge.rows);
  int column = 0;
  for (int b = 0; b < edge.num_blocks; ++b) {
    const int p = linearization.positions(edge)[b];
    const int size = layout.block_size(p);
    factor.jacobian.emplace_back(layout.blocks[static_cast<std::size_t>(p)],
                                 per_row * linearization.jacobian(edge).middleCols(column, size));
    column += size;
  }
  return factor;
}

LinearizedNetwork::Factor LinearizedNetwork::Impl::EvaluateIdleFactor(const IdleFactor& of,
                                                                      FactorId id) const {
  std::vector<const double*> x;
  for (const BlockId b : of.blocks) x.push_back(values.data() + block(b).value);
  Factor factor;
  std::vector<Eigen::MatrixXd> J;
  if (!EvaluateInTangent(*of.factor, x, &factor.residual, &J)) {
    throw InvalidInput("linearised network: factor " + std::to_string(id) +
                       ", which is not active, is undefined at these values");
  }
  for (std::size_t b = 0; b < J.size(); ++b) {
    if (!block(of.blocks[b]).held) factor.jacobian.emplace_back(of.blocks[b], std::move(J[b]));
  }
  return factor;
}

LinearizedNetwork::LinearizedNetwork(const Network& network, int threads)
    : impl_(std::make_shared<Impl>(network, threads)) {}

LinearizedNetwork LinearizedNetwork::Scaled(const Eigen::VectorXd& row_scale) const {
  ExpectRows(row_scale.size(), rows(), "residuals to scale");
  for (Eigen::Index row = 0; row < rows(); ++row) {
    if (row_scale[row] > 0.0 && std::isfinite(row_scale[row])) continue;
    throw InvalidInput("linearised network: the scale of row " + std::to_string(row) + " is " +
                       std::to_string(row_scale[row]) + ", must be positive and finite");
  }
  return LinearizedNetwork(std::make_shared<const Impl>(*impl_, row_scale));
}

const Eigen::VectorXd& LinearizedNetwork::row_scale() const { return impl_->row_scale; }

Eigen::MatrixXd ToRowScaling(const LinearizedNetwork& linearized,
                             const LinearizedNetwork::FactorRows& rows, const Eigen::MatrixXd& L) {
  ExpectRows(L.rows(), rows.count, "residuals of the factor");
  return std::sqrt(rows.weight) *
         (linearized.row_scale().segment(rows.first, rows.count).asDiagonal() * L);
}

int LinearizedNetwork::parameters() const { return impl_->layout.size(); }

const Eigen::VectorXd& LinearizedNetwork::residual() const {
  return impl_->linearization.residual();
}

const std::vector<BlockId>& LinearizedNetwork::unknowns() const { return impl_->layout.blocks; }

int LinearizedNetwork::FirstColumn(BlockId block) const {
  impl_->block(block);
  const int position = impl_->layout.block_position[static_cast<std::size_t>(block)];
  return position < 0 ? -1 : impl_->layout.offset[static_cast<std::size_t>(position)];
}

const std::vector<LinearizedNetwork::FactorRows>& LinearizedNetwork::factors() const {
  return impl_->factor_rows;
}

std::optional<LinearizedNetwork::FactorRows> LinearizedNetwork::FindRows(FactorId factor) const {
  const int edge = impl_->factor(factor).edge;
  if (edge < 0) return std::nullopt;
  return impl_->factor_rows[static_cast<std::size_t>(edge)];
}

const FactorGroup& LinearizedNetwork::group(FactorId factor) const {
  return impl_->groups[static_cast<std::size_t>(impl_->factor(factor).group)];
}

double LinearizedNetwork::t_s(FactorId factor) const { return impl_->factor(factor).t_s; }

LinearizedNetwork::Row FindRow(const LinearizedNetwork& linearized, Eigen::Index row) {
  if (row < 0 || row >= linearized.rows()) {
    throw InvalidInput("linearised network: no row " + std::to_string(row) + " of " +
                       std::to_string(linearized.rows()));
  }
  const std::vector<LinearizedNetwork::FactorRows>& factors = linearized.factors();
  const auto past =
      std::upper_bound(factors.begin(), factors.end(), row,
                       [](Eigen::Index wanted, const LinearizedNetwork::FactorRows& rows) {
                         return wanted < rows.first;
                       });
  const FactorId factor = std::prev(past)->factor;
  const int residual = static_cast<int>(row) - std::prev(past)->first;
  const FactorGroup& group = linearized.group(factor);
  return {factor, residual, group.Channel(residual), group.Axis(residual), linearized.t_s(factor)};
}

LinearizedNetwork::Factor LinearizedNetwork::EvaluateFactorAt(FactorId factor) const {
  const int edge = impl_->factor(factor).edge;
  if (edge < 0) return impl_->EvaluateIdleFactor(impl_->idle_factor(factor), factor);
  return impl_->ActiveFactor(impl_->linearization.edges()[static_cast<std::size_t>(edge)]);
}

void LinearizedNetwork::CheckHandle(BlockId block, const BlockKind& kind, NetworkId network) const {
  const Impl::BlockInfo& info = impl_->block(block);
  dn::CheckHandle(info.name, info.kind, info.network, kind, network);
}

const double* LinearizedNetwork::StoredValue(BlockId block) const {
  return impl_->values.data() + impl_->block(block).value;
}

Eigen::MatrixXd LinearizedNetwork::Times(const Eigen::MatrixXd& X) const {
  ExpectRows(X.rows(), parameters(), "unknowns");
  const Linearization& linearization = impl_->linearization;
  Eigen::MatrixXd E = Eigen::MatrixXd::Zero(rows(), X.cols());
  ParallelFor(static_cast<int>(linearization.edges().size()), impl_->threads, [&](int e) {
    const Linearization::Edge& edge = linearization.edges()[static_cast<std::size_t>(e)];
    linearization.AddProduct(edge, X, E.middleRows(edge.first_row, edge.rows));
  });
  return E;
}

Eigen::MatrixXd LinearizedNetwork::TransposeTimes(const Eigen::MatrixXd& E) const {
  ExpectRows(E.rows(), rows(), "residuals");
  return impl_->linearization.TransposeTimes(E);
}

}  // namespace dn
