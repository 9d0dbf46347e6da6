#pragma once

#include <dn/solvers/marginals.h>

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "linearized_impl.h"
#include "sparse/sparse.h"

namespace dn {

class ProblemNetwork;

struct Marginals::Impl {
  using BlockInfo = LinearizedNetwork::Impl::BlockInfo;

  Impl(LinearizedNetwork snapshot, const MarginalsOptions& options);

  const LinearizedNetwork::Impl& network() const { return linearized.impl(); }
  const UnknownLayout& layout() const { return network().layout; }
  const BlockInfo& block(BlockId b) const { return network().block(b); }

  /// Returns the position of a block in the layout, or -1 for a constant block. Throws
  /// RankDeficient for a block without an active factor.
  int Position(BlockId b) const;
  int Offset(int position) const { return layout().offset[static_cast<std::size_t>(position)]; }

  Eigen::MatrixXd Solve(const std::vector<BlockId>& ids) const;
  Eigen::MatrixXd Solve(const BlockColumns& rhs) const;
  /// Returns scale (scale N scale)^-1 B.
  Eigen::MatrixXd SolveScaled(Eigen::MatrixXd B) const;

  /// Applies M = I - J N^-1 J^T to vectors that are the rows of E.
  void Project(Eigen::Ref<Eigen::MatrixXd> E) const;

  const Eigen::MatrixXd& CachedColumns(BlockId b);
  Eigen::MatrixXd Rows(const Eigen::MatrixXd& columns, BlockId b) const;
  std::optional<Eigen::MatrixXd> Selected(BlockId a, BlockId b) const;
  std::optional<Eigen::MatrixXd> Selected(std::span<const BlockId> blocks) const;
  void RequireSelected() const;

  LinearizedNetwork linearized;
  std::shared_ptr<const ProblemNetwork> problem;  ///< only for a ceres::Problem
  int threads = 1;
  Eigen::VectorXd scale;  ///< scale of the unknowns: the factored matrix is scale N scale
  std::unique_ptr<sparse::Cholesky> cholesky;
  std::unique_ptr<sparse::SelectedInverse> selected;
  Timings timings;
  std::map<BlockId, Eigen::MatrixXd> cache;
  std::size_t cached = 0;

 private:
  void Factor(const MarginalsOptions& options);
  void ExamineRank(const sparse::SymmetricCsc& scaled_N, bool definite, double tolerance);
};

}  // namespace dn
