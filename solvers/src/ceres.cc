#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <dn/ceres.h>
#include <dn/error.h>
#include <dn/solvers/robust_loss.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "block_manifold.h"

namespace dn {
namespace {

/// Cost function of a factor.
class FactorCostFunction : public ceres::CostFunction {
 public:
  explicit FactorCostFunction(std::shared_ptr<const FactorBase> factor)
      : factor_(std::move(factor)) {
    set_num_residuals(factor_->residual_size());
    for (const BlockKind& kind : factor_->block_kinds()) {
      mutable_parameter_block_sizes()->push_back(kind.stored_size);
    }
  }

  bool Evaluate(double const* const* x, double* r, double** J) const override {
    try {
      return EvaluateStored(*factor_, x, r, J);
    } catch (...) {
      return false;
    }
  }

 private:
  std::shared_ptr<const FactorBase> factor_;
};

/// Cost function of a factor of a network, which stores exceptions.
class NetworkCostFunction final : public FactorCostFunction {
 public:
  NetworkCostFunction(const Network& network, FactorId id,
                      solvers_internal::FactorException* exception)
      : FactorCostFunction(network.factor(id).factor),
        network_(network),
        id_(id),
        exception_(exception) {}

  bool Evaluate(double const* const* x, double* r, double** J) const override {
    if (exception_->present()) return false;
    try {
      return network_.EvaluateStored(id_, x, r, J);
    } catch (...) {
      exception_->Store(std::current_exception());
      return false;
    }
  }

 private:
  const Network& network_;
  FactorId id_;
  solvers_internal::FactorException* exception_;
};

/// A user's loss function with first-order weights.
class OwnLoss final : public ceres::LossFunction {
 public:
  explicit OwnLoss(Loss loss) : loss_(std::move(loss)) {}
  void Evaluate(double s, double rho[3]) const override {
    const LossValue value = EvaluateLoss(loss_, s);
    rho[0] = value.rho;
    rho[1] = value.rho_prime;
    rho[2] = 0.0;
  }

 private:
  Loss loss_;
};

std::unique_ptr<ceres::LossFunction> MakeLoss(const Loss& loss) {
  switch (loss.type) {
    case Loss::Type::kHuber:
      return std::make_unique<ceres::HuberLoss>(loss.width);
    case Loss::Type::kCauchy:
      return std::make_unique<ceres::CauchyLoss>(loss.width);
    case Loss::Type::kFunction:
      return std::make_unique<OwnLoss>(loss);
    case Loss::Type::kNone:
      break;
  }
  return nullptr;
}

ceres::Problem::Options Ownership() {
  ceres::Problem::Options options;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

}  // namespace

namespace solvers_internal {

bool BlockManifold::Plus(const double* x, const double* d, double* x_plus_d) const {
  dn::Plus(kind_, x, d, x_plus_d);
  return true;
}

bool BlockManifold::PlusJacobian(const double* x, double* J) const {
  if (kind_.parametrisation == Parametrisation::kManifold) {
    kind_.manifold->PlusJacobian(x, J);
  } else if (kind_.parametrisation == Parametrisation::kVector) {
    Eigen::Map<Eigen::MatrixXd>(J, kind_.stored_size, kind_.stored_size).setIdentity();
  } else {
    Eigen::Map<Eigen::Matrix<double, 4, 3, Eigen::RowMajor>> out(J);
    out = RotationPlusJacobian(kind_.parametrisation, x);
  }
  return true;
}

bool BlockManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  dn::Minus(kind_, y, x, y_minus_x);
  return true;
}

bool BlockManifold::MinusJacobian(const double* x, double* J) const {
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> out(
      J, kind_.tangent_size, kind_.stored_size);
  out = TangentLift(kind_, x);
  return true;
}

void FactorException::Store(std::exception_ptr exception) {
  const std::scoped_lock lock(mutex_);
  if (!exception_) exception_ = std::move(exception);
  present_ = true;
}

void FactorException::Rethrow() const {
  if (exception_) std::rethrow_exception(exception_);
}

}  // namespace solvers_internal

std::unique_ptr<ceres::Manifold> MakeCeresManifold(const BlockKind& kind) {
  if (kind.stored_size < 1) throw InvalidInput("ceres: a block kind of size 0 has no manifold");
  return std::make_unique<solvers_internal::BlockManifold>(kind);
}

std::unique_ptr<ceres::CostFunction> MakeCostFunction(std::shared_ptr<const FactorBase> factor) {
  if (factor == nullptr) throw InvalidInput("ceres: no factor is given for a cost function");
  return std::make_unique<FactorCostFunction>(std::move(factor));
}

NetworkProblem::NetworkProblem(Network& network) : problem_(Ownership()) {
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    if (network.factor(id).active) AddFactor(network, id);
  }
}

NetworkProblem::~NetworkProblem() = default;

void NetworkProblem::AddFactor(Network& network, FactorId id) {
  const FactorRecord& record = network.factor(id);
  std::vector<double*> values;
  for (const BlockId b : record.blocks) {
    AddBlock(network.block(b));
    values.push_back(network.block(b).value.get());
  }
  auto cost = std::make_unique<NetworkCostFunction>(network, id, &exception_);
  problem_.AddResidualBlock(cost.release(), MakeLoss(record.loss).release(), values);
}

void NetworkProblem::AddBlock(BlockRecord& block) {
  double* value = block.value.get();
  if (problem_.HasParameterBlock(value)) return;
  problem_.AddParameterBlock(value, block.kind.stored_size, FindManifold(block.kind));
  if (block.held) problem_.SetParameterBlockConstant(value);
}

ceres::Manifold* NetworkProblem::FindManifold(const BlockKind& kind) {
  if (kind.parametrisation == Parametrisation::kVector) return nullptr;
  for (const auto& [known, manifold] : manifolds_) {
    if (known == kind) return manifold.get();
  }
  return manifolds_.emplace_back(kind, MakeCeresManifold(kind)).second.get();
}

}  // namespace dn
