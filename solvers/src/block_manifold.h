#pragma once

#include <ceres/manifold.h>
#include <dn/block.h>

namespace dn::solvers_internal {

/// Ceres manifold of a block kind, with the tangent of dn::Plus.
class BlockManifold final : public ceres::Manifold {
 public:
  explicit BlockManifold(const BlockKind& kind) : kind_(kind) {}

  int AmbientSize() const override { return kind_.stored_size; }
  int TangentSize() const override { return kind_.tangent_size; }
  bool Plus(const double* x, const double* d, double* x_plus_d) const override;
  bool PlusJacobian(const double* x, double* J) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* J) const override;
  const BlockKind& kind() const { return kind_; }

 private:
  BlockKind kind_;
};

}  // namespace dn::solvers_internal
