#pragma once

#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <dn/network.h>

#include <atomic>
#include <deque>
#include <exception>
#include <mutex>

namespace dn::internal {

/// Ceres manifold of a block that is not a vector, with the tangent of dn::Plus. Ceres's own
/// rotation manifolds use half the angle.
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

/// Stores the exception of a factor while Ceres is running, because exceptions cannot cross its
/// threads.
class FactorException {
 public:
  bool present() const { return present_; }
  void Store(std::exception_ptr exception);
  /// Throws the stored exception, if there is one.
  void Rethrow() const;

 private:
  std::atomic<bool> present_ = false;
  std::mutex mutex_;
  std::exception_ptr exception_;
};

/// The active factors of a network as a ceres::Problem that works on the values stored in the
/// network. The network must outlive it.
class CeresProblem {
 public:
  explicit CeresProblem(Network& network);

  ceres::Problem& problem() { return problem_; }

  /// Throws the exception that a factor threw during an evaluation.
  void RethrowFactorException() const { exception_.Rethrow(); }

 private:
  void AddFactor(Network& network, FactorId id);
  void AddBlock(BlockRecord& block);
  ceres::Manifold* FindManifold(const BlockKind& kind);

  FactorException exception_;
  std::deque<BlockManifold> manifolds_;
  ceres::Problem problem_;
};

}  // namespace dn::internal
