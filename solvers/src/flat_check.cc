#include "flat_check.h"

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

/// Ratio of the influence to its initial value below which it counts as lost.
constexpr double kLost = 1e-8;
/// Largest change of the residuals, relative to their norm, when the unknown is moved back.
constexpr double kNoReturn = 1e-8;

struct Influences {
  /// Norms of the Jacobian columns of each block; empty for a constant block.
  std::vector<Eigen::VectorXd> block_influence;
  double residual2 = 0.0;
};

Influences FindInfluences(const Network& network) {
  Influences all;
  all.block_influence.resize(static_cast<std::size_t>(network.num_blocks()));
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    const FactorRecord& record = network.factor(id);
    if (!record.active || !network.EvaluateFactor(id, &r, &J)) continue;
    all.residual2 += r.squaredNorm();
    for (std::size_t i = 0; i < J.size(); ++i) {
      if (network.block(record.blocks[i]).held) continue;
      Eigen::VectorXd& sum = all.block_influence[static_cast<std::size_t>(record.blocks[i])];
      if (sum.size() == 0) sum = Eigen::VectorXd::Zero(J[i].cols());
      sum += J[i].colwise().squaredNorm().transpose();
    }
  }
  for (Eigen::VectorXd& sum : all.block_influence) sum = sum.cwiseSqrt().eval();
  return all;
}

std::string ComponentName(const BlockRecord& block, Eigen::Index k) {
  std::string name = block.name;
  if (block.kind.tangent_size > 1) name.append("[").append(std::to_string(k)).append("]");
  return name;
}

}  // namespace

NetworkValues::NetworkValues(const Network& network) {
  for (BlockId b = 0; b < network.num_blocks(); ++b) {
    const BlockRecord& block = network.block(b);
    first_.push_back(values_.size());
    values_.insert(values_.end(), block.value.get(), block.value.get() + block.kind.stored_size);
  }
}

void NetworkValues::Restore(Network* network) const {
  for (BlockId b = 0; b < network->num_blocks(); ++b) {
    BlockRecord& block = network->block(b);
    std::copy_n(value(b), block.kind.stored_size, block.value.get());
  }
}

PlateauCheck::PlateauCheck(const Network& network)
    : initial_(network), influence_(FindInfluences(network).block_influence) {}

std::string PlateauCheck::FindPlateauUnknown(const Network& network) const {
  const Influences now = FindInfluences(network);
  for (BlockId b = 0; b < network.num_blocks(); ++b) {
    const Eigen::VectorXd& before = influence_[static_cast<std::size_t>(b)];
    const Eigen::VectorXd& after = now.block_influence[static_cast<std::size_t>(b)];
    if (before.size() != after.size()) continue;
    const BlockRecord& block = network.block(b);
    Eigen::VectorXd moved(block.kind.tangent_size);
    Minus(block.kind, block.value.get(), initial_.value(b), moved.data());
    for (Eigen::Index k = 0; k < after.size(); ++k) {
      const bool lost = after[k] < kLost * before[k];
      const bool stays = after[k] * std::abs(moved[k]) <= kNoReturn * std::sqrt(now.residual2);
      if (lost && stays) return ComponentName(block, k);
    }
  }
  return "";
}

}  // namespace dn
