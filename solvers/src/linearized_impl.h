#pragma once

#include <dn/solvers/linearized_network.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "linearization.h"

namespace dn {

struct LinearizedNetwork::Impl {
  /// A block as it was.
  struct BlockInfo {
    std::string name;
    BlockKind kind;
    bool held;
    BlockLabel label;
    std::size_t value;  ///< into values
  };

  /// What is known of every factor.
  struct FactorInfo {
    int edge;  ///< into the edges; -1: not active
    int group;
    double t_s;
  };

  /// A factor that takes no part, to be evaluated when it is asked for.
  struct IdleFactor {
    std::shared_ptr<const FactorBase> factor;
    std::vector<BlockId> blocks;
  };

  Impl(const Network& network, int threads);
  Impl(const Impl& other, const Eigen::VectorXd& scale);

  const BlockInfo& block(BlockId b) const;
  const FactorInfo& factor(FactorId id) const;
  /// Of one that is not active.
  const IdleFactor& idle_factor(FactorId id) const;
  int residual_size(FactorId id) const;
  Factor OfEdge(const Linearization::Edge& edge) const;
  Factor OfIdle(const IdleFactor& idle, FactorId id) const;

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
