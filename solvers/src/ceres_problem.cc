#include "ceres_problem.h"

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <memory>
#include <vector>

namespace dn::internal {
namespace {

/// Lets Ceres evaluate a factor of the network.
class FactorCost final : public ceres::CostFunction {
 public:
  explicit FactorCost(const FactorBase& factor) : factor_(factor) {
    set_num_residuals(factor.residual_size());
    for (const BlockKind& kind : factor.block_kinds()) {
      mutable_parameter_block_sizes()->push_back(kind.stored_size);
    }
  }

  bool Evaluate(double const* const* x, double* r, double** J) const override {
    return factor_.Evaluate(x, r, J);
  }

 private:
  const FactorBase& factor_;
};

std::unique_ptr<ceres::LossFunction> MakeLoss(const Loss& loss) {
  switch (loss.type) {
    case Loss::Type::kHuber:
      return std::make_unique<ceres::HuberLoss>(loss.width);
    case Loss::Type::kCauchy:
      return std::make_unique<ceres::CauchyLoss>(loss.width);
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

bool RotationManifold::Plus(const double* x, const double* d, double* x_plus_d) const {
  dn::Plus(kind_, x, d, x_plus_d);
  return true;
}

bool RotationManifold::PlusJacobian(const double* x, double* J) const {
  Eigen::Map<Eigen::Matrix<double, 4, 3, Eigen::RowMajor>> out(J);
  out = RotationPlusJacobian(kind_.parametrisation, x);
  return true;
}

bool RotationManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  dn::Minus(kind_, y, x, y_minus_x);
  return true;
}

bool RotationManifold::MinusJacobian(const double* x, double* J) const {
  Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> out(J);
  out = 4.0 * RotationPlusJacobian(kind_.parametrisation, x).transpose();
  return true;
}

CeresProblem::CeresProblem(Network& network) : problem_(Ownership()) {
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    if (network.factor(id).active) AddFactor(network, network.factor(id));
  }
}

void CeresProblem::AddFactor(Network& network, const FactorRecord& record) {
  std::vector<double*> values;
  for (const BlockId b : record.blocks) {
    AddBlock(network.block(b));
    values.push_back(network.block(b).value.get());
  }
  auto cost = std::make_unique<FactorCost>(*record.factor);
  problem_.AddResidualBlock(cost.release(), MakeLoss(record.loss).release(), values);
}

void CeresProblem::AddBlock(BlockRecord& block) {
  double* value = block.value.get();
  if (problem_.HasParameterBlock(value)) return;
  problem_.AddParameterBlock(value, block.kind.stored_size, ManifoldOf(block.kind));
  if (block.held) problem_.SetParameterBlockConstant(value);
}

ceres::Manifold* CeresProblem::ManifoldOf(const BlockKind& kind) {
  switch (kind.parametrisation) {
    case Parametrisation::kRotationRight:
      return &right_;
    case Parametrisation::kRotationLeft:
      return &left_;
    case Parametrisation::kVector:
      break;
  }
  return nullptr;
}

}  // namespace dn::internal
