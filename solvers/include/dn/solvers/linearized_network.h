#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// A network linearised at its current values,
///
///   e(x + dx) = r + J dx.
///
/// r and J are whitened and in tangent coordinates. Each row is multiplied by the square root of
/// the weight that the robust loss gives to its factor. The factors are evaluated once, in the
/// constructor; covariances, predictions, tests and statistics all use this snapshot. Later changes
/// of the network have no effect on it.
///
/// Rows: the residuals of the active factors, factor after factor. Columns: the blocks that are not
/// constant and have an active factor, in the order of the network.
///
/// Copies share their data, which never changes, so any number of threads may read.
class LinearizedNetwork {
 public:
  struct Impl;

  /// Rows of one factor: first, first + 1, ..., first + count - 1.
  struct FactorRows {
    FactorId factor = -1;
    int first = 0;
    int count = 0;
    /// rho' of its robust loss; r and J contain its square root, see ToRowScaling.
    double weight = 1.0;
  };

  /// Identification of a row.
  struct Row {
    FactorId factor = -1;
    int residual = 0;     ///< index of the residual within the factor
    std::string channel;  ///< FactorGroup::Channel; empty if the factor has no tag
    std::string axis;
    double t_s = 0.0;  ///< NaN for a factor without an epoch
  };

  /// One factor: its whitened residual without the robust weight, and d residual / d block for each
  /// of its blocks that is not constant. Both include the row scale if the factor is active.
  struct Factor {
    Eigen::VectorXd residual;
    std::vector<std::pair<BlockId, Eigen::MatrixXd>> jacobian;
    /// Weight in the network: rho' of its loss; 0 if the factor is not active.
    double weight = 0.0;
  };

  /// Evaluates the active factors with `threads` threads; later products use the same number.
  /// Throws InvalidInput naming a factor that is undefined at the current values.
  explicit LinearizedNetwork(const Network& network, int threads = 1);

  /// Returns the network with other noise: row i of r and J is multiplied by row_scale[i]. This
  /// corresponds to multiplying its standard deviation by 1 / row_scale[i]. Robust weights keep the
  /// values from the original noise. The result contains a second copy of r and J. Throws
  /// InvalidInput for a wrong number of rows, or a scale that is not positive and finite.
  LinearizedNetwork Scaled(const Eigen::VectorXd& row_scale) const;
  /// Returns the product of all scales applied so far; ones if there were none.
  const Eigen::VectorXd& row_scale() const;

  Eigen::Index rows() const { return residual().size(); }
  int parameters() const;
  const Eigen::VectorXd& residual() const;

  /// Returns the unknowns in the order of their columns.
  const std::vector<BlockId>& unknowns() const;
  /// Returns the first column of a block, or -1 if the block is not an unknown.
  int FirstColumn(BlockId block) const;

  const std::vector<FactorRows>& factors() const;
  /// Returns the rows of a factor, or nullopt if it is not active. Throws InvalidInput for an
  /// unknown id.
  std::optional<FactorRows> FindRows(FactorId factor) const;
  const FactorGroup& group(FactorId factor) const;
  double t_s(FactorId factor) const;

  /// Returns a factor at the values of the snapshot, active or not. An inactive factor is evaluated
  /// by this call; throws InvalidInput if it is undefined.
  Factor EvaluateFactorAt(FactorId factor) const;

  /// Returns the value of a block in the snapshot.
  template <class Kind>
  BlockValue<Kind> Value(Block<Kind> b) const {
    return BlockValue<Kind>(MakeView<Kind>(StoredValue(Id(b))));
  }
  /// Returns the id of a block. Throws InvalidInput if the handle belongs to a network other than
  /// the linearised one and its copies.
  template <class Kind>
  BlockId Id(Block<Kind> b) const {
    CheckHandle(b.id, MakeBlockKind<Kind>(), b.network);
    return b.id;
  }
  /// Returns the stored coordinates of a block in the snapshot.
  const double* StoredValue(BlockId block) const;

  /// Returns J X or J^T E.
  Eigen::MatrixXd Times(const Eigen::MatrixXd& X) const;
  Eigen::MatrixXd TransposeTimes(const Eigen::MatrixXd& E) const;

  /// Internal: only the sources of this layer use it.
  const Impl& impl() const { return *impl_; }

 private:
  explicit LinearizedNetwork(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  void CheckHandle(BlockId block, const BlockKind& kind, NetworkId network) const;

  std::shared_ptr<const Impl> impl_;
};

/// Returns the identification of a row. Throws InvalidInput if there is no such row.
LinearizedNetwork::Row FindRow(const LinearizedNetwork& linearized, Eigen::Index row);

/// Converts derivatives L of the whitened residual of an active factor (its rows x any number of
/// columns) to the scaling of r and J. It multiplies them by the square root of the robust weight
/// and by the row scale.
Eigen::MatrixXd ToRowScaling(const LinearizedNetwork& linearized,
                             const LinearizedNetwork::FactorRows& rows, const Eigen::MatrixXd& L);

}  // namespace dn
