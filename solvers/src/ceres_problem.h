#pragma once

#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <dn/network.h>

namespace dn::internal {

/// A rotation block with the full-angle tangent of dn::Plus (Ceres's own has half the angle).
class RotationManifold final : public ceres::Manifold {
 public:
  explicit RotationManifold(const BlockKind& kind) : kind_(kind) {}

  int AmbientSize() const override { return 4; }
  int TangentSize() const override { return 3; }
  bool Plus(const double* x, const double* d, double* x_plus_d) const override;
  bool PlusJacobian(const double* x, double* J) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* J) const override;

 private:
  BlockKind kind_;
};

/// The active factors of a network as a ceres::Problem on the network's own values. The network
/// outlives it.
class CeresProblem {
 public:
  explicit CeresProblem(Network& network);

  ceres::Problem& problem() { return problem_; }

 private:
  void AddFactor(Network& network, const FactorRecord& record);
  void AddBlock(BlockRecord& block);
  ceres::Manifold* ManifoldOf(const BlockKind& kind);

  RotationManifold right_{Rotation::kKind};
  RotationManifold left_{LeftRotation::kKind};
  ceres::Problem problem_;
};

}  // namespace dn::internal
