#pragma once

#include <dn/network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

namespace dn {

/// A network at its present values as one linear system,
///
///   e(x + dx) = r + J dx,
///
/// r and J whitened, in tangent coordinates, every row times the root of the weight that the robust
/// loss of its factor gives it. Later changes of the network are not seen.
///
/// Rows: the residuals of the active factors that depend on an unknown, factor after factor.
/// Columns: the blocks that are free and have an active factor, in the order of the network.
class LinearizedNetwork {
 public:
  /// The rows of one factor: first, first + 1, .. , first + count - 1.
  struct FactorRows {
    FactorId factor = -1;
    int first = 0;
    int count = 0;
  };

  /// Throws InvalidInput naming a factor that is undefined at the present values.
  explicit LinearizedNetwork(const Network& network, int threads = 1);
  ~LinearizedNetwork();
  LinearizedNetwork(LinearizedNetwork&&) noexcept;
  LinearizedNetwork& operator=(LinearizedNetwork&&) noexcept;

  Eigen::Index rows() const { return residual().size(); }
  int parameters() const;
  /// First column of a block; -1 where it is none of the unknowns.
  int FirstColumn(BlockId block) const;
  const Eigen::VectorXd& residual() const;
  const std::vector<FactorRows>& factors() const { return factors_; }

  /// J X, J^T E.
  Eigen::MatrixXd Times(const Eigen::MatrixXd& X) const;
  Eigen::MatrixXd TransposeTimes(const Eigen::MatrixXd& E) const;

  /// M E with M = I - J N^-1 J^T: what a fit leaves of the errors E. Of E ~ N(0, I) it is a sample
  /// of the residuals that the network leaves when its model holds, whatever the unknowns are.
  /// `marginals` must be of the same network at the same values.
  Eigen::MatrixXd Project(const Eigen::MatrixXd& E, const Marginals& marginals) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::vector<FactorRows> factors_;
  int threads_;
};

}  // namespace dn
