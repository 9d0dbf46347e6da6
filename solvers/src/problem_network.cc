#include <ceres/loss_function.h>
#include <dn/ceres.h>
#include <dn/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "block_manifold.h"
#include "marginals_impl.h"

namespace dn {
namespace {

/// Manifold of a ceres::Problem as the functions of a block kind.
class CeresManifoldFunctions final : public ManifoldFunctions {
 public:
  /// x: a value on the manifold.
  CeresManifoldFunctions(const ceres::Manifold& manifold, const double* x)
      : manifold_(manifold), has_minus_(TryMinus(x, x).has_value()) {}

  void Plus(const double* x, const double* d, double* x_plus_d) const override {
    if (manifold_.Plus(x, d, x_plus_d)) return;
    std::fill_n(x_plus_d, manifold_.AmbientSize(), std::numeric_limits<double>::quiet_NaN());
  }
  void Minus(const double* y, const double* x, double* y_minus_x) const override {
    const std::optional<Eigen::VectorXd> d = TryMinus(y, x);
    const Eigen::VectorXd difference = d ? *d : LinearMinus(y, x);
    std::copy_n(difference.data(), difference.size(), y_minus_x);
  }
  void PlusJacobian(const double* x, double* J) const override {
    if (manifold_.PlusJacobian(x, J)) return;
    std::fill_n(J, manifold_.AmbientSize() * manifold_.TangentSize(),
                std::numeric_limits<double>::quiet_NaN());
  }
  bool has_exact_minus() const override { return has_minus_; }

  BlockKind kind() const {
    return {Parametrisation::kManifold, manifold_.AmbientSize(), manifold_.TangentSize(), this};
  }

 private:
  /// Returns nullopt if the manifold does not compute Minus.
  std::optional<Eigen::VectorXd> TryMinus(const double* y, const double* x) const {
    Eigen::VectorXd d = Eigen::VectorXd::Constant(manifold_.TangentSize(),
                                                  std::numeric_limits<double>::quiet_NaN());
    if (!manifold_.Minus(y, x, d.data()) || !d.allFinite()) return std::nullopt;
    return d;
  }
  /// Returns Minus to first order.
  Eigen::VectorXd LinearMinus(const double* y, const double* x) const {
    const Eigen::Map<const Eigen::VectorXd> to(y, manifold_.AmbientSize());
    const Eigen::Map<const Eigen::VectorXd> from(x, manifold_.AmbientSize());
    return TangentLift(kind(), x) * (to - from);
  }

  const ceres::Manifold& manifold_;
  bool has_minus_;
};

/// Residual block of a ceres::Problem as a factor. The problem owns the cost function.
class CostFactor final : public DynamicFactor {
 public:
  CostFactor(const ceres::CostFunction& cost, std::vector<BlockKind> kinds)
      : DynamicFactor(cost.num_residuals(), std::move(kinds)), cost_(cost) {}
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    return cost_.Evaluate(x, r, J);
  }

 private:
  const ceres::CostFunction& cost_;
};

Loss ToLoss(const ceres::LossFunction* loss) {
  if (loss == nullptr) return {};
  return Loss::Own([loss](double s) {
    std::array<double, 3> rho;
    loss->Evaluate(s, rho.data());
    return std::array{rho[0], rho[1]};
  });
}

/// The kinds of the parameter blocks; blocks with the same manifold share theirs.
class ParameterKinds {
 public:
  struct Kind {
    BlockKind kind;
    std::shared_ptr<const void> owner;
  };

  Kind Find(const ceres::Problem& problem, const double* x) {
    const ceres::Manifold* manifold = problem.GetManifold(x);
    if (manifold == nullptr || manifold->TangentSize() == 0) {
      return {VectorKind(problem.ParameterBlockSize(x)), nullptr};
    }
    if (const auto* block = dynamic_cast<const solvers_internal::BlockManifold*>(manifold)) {
      return {block->kind(), nullptr};
    }
    std::shared_ptr<const CeresManifoldFunctions>& functions = known_[manifold];
    if (!functions) functions = std::make_shared<const CeresManifoldFunctions>(*manifold, x);
    return {functions->kind(), functions};
  }

 private:
  std::map<const ceres::Manifold*, std::shared_ptr<const CeresManifoldFunctions>> known_;
};

bool IsConstant(const ceres::Problem& problem, const double* x) {
  return problem.IsParameterBlockConstant(x) || problem.ParameterBlockTangentSize(x) == 0;
}

}  // namespace

ProblemNetwork::ProblemNetwork(const ceres::Problem& problem,
                               const std::map<const double*, std::string>& names) {
  problem.GetParameterBlocks(&parameter_blocks_);
  ParameterKinds kinds;
  for (const double* x : parameter_blocks_) {
    const ParameterKinds::Kind found = kinds.Find(problem, x);
    const auto name = names.find(x);
    const BlockId id = network_.AddBlock(
        name == names.end() ? "block/" + std::to_string(ids_.size()) : name->second, found.kind,
        Eigen::Map<const Eigen::VectorXd>(x, found.kind.stored_size), found.owner);
    ids_.emplace(x, id);
    network_.Hold(id, IsConstant(problem, x));
  }
  std::vector<ceres::ResidualBlockId> residual_blocks;
  problem.GetResidualBlocks(&residual_blocks);
  for (const ceres::ResidualBlockId residual_block : residual_blocks) {
    std::vector<double*> parameters;
    problem.GetParameterBlocksForResidualBlock(residual_block, &parameters);
    std::vector<BlockId> blocks;
    std::vector<BlockKind> block_kinds;
    for (const double* x : parameters) {
      blocks.push_back(Find(x));
      block_kinds.push_back(network_.block(blocks.back()).kind);
    }
    const FactorId id = network_.AddFactor(
        std::make_shared<CostFactor>(*problem.GetCostFunctionForResidualBlock(residual_block),
                                     std::move(block_kinds)),
        blocks);
    network_.SetLoss(id, ToLoss(problem.GetLossFunctionForResidualBlock(residual_block)));
  }
}

BlockId ProblemNetwork::Find(const double* parameter_block) const {
  const auto found = ids_.find(parameter_block);
  if (found == ids_.end()) {
    throw InvalidInput("ceres: the problem has no parameter block at this address");
  }
  return found->second;
}

Marginals::Marginals(const ceres::Problem& problem, const MarginalsOptions& options) {
  const auto network = std::make_shared<const ProblemNetwork>(problem);
  *this = Marginals(network->network(), options);
  impl_->problem = network;
}

BlockId Marginals::Find(const double* parameter_block) const {
  if (!impl_->problem) {
    throw InvalidInput("marginals: parameter blocks belong to a ceres::Problem; use the block id");
  }
  return impl_->problem->Find(parameter_block);
}

void ProblemNetwork::StoreValues() const {
  for (BlockId id = 0; id < network_.num_blocks(); ++id) {
    const BlockRecord& block = network_.block(id);
    std::copy_n(block.value.get(), block.kind.stored_size,
                parameter_blocks_[static_cast<std::size_t>(id)]);
  }
}

}  // namespace dn
