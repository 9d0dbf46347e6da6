#pragma once

#include <dn/solvers/linearized_network.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "linearization.h"

namespace dn {

struct LinearizedNetwork::Impl {
  /// Snapshot of a block.
  struct BlockInfo {
    std::string name;
    BlockKind kind;
    bool held;
    BlockLabel label;
    std::size_t value;  ///< offset in `values`
    NetworkId network;
  };

  /// Data of every factor, active or not.
  struct FactorInfo {
    int edge;  ///< index of its edge; -1 if it is not active
    int group;
    double t_s;
  };

  /// An inactive factor, which is evaluated only on request.
  struct IdleFactor {
    std::shared_ptr<const FactorBase> factor;
    std::vector<BlockId> blocks;
  };

  Impl(const Network& network, int threads);
  Impl(const Impl& other, const Eigen::VectorXd& scale);

  const BlockInfo& block(BlockId b) const;
  const FactorInfo& factor(FactorId id) const;
  /// Returns an inactive factor.
  const IdleFactor& idle_factor(FactorId id) const;
  int residual_size(FactorId id) const;
  Factor ActiveFactor(const Linearization::Edge& edge) const;
  Factor EvaluateIdleFactor(const IdleFactor& idle, FactorId id) const;

  int threads;
  UnknownLayout layout;
  Linearization linearization;
  Eigen::VectorXd row_scale;
  std::vector<FactorRows> factor_rows;
  std::vector<FactorInfo> factors;
  std::map<FactorId, IdleFactor> idle;
  std::vector<FactorGroup> groups;
  std::vector<BlockInfo> blocks;
  std::vector<double> values;
};

}  // namespace dn
