#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// A network at its present values as one linear system,
///
///   e(x + dx) = r + J dx,
///
/// r and J whitened, in tangent coordinates, every row times the root of the weight that the robust
/// loss of its factor gives it. The factors are evaluated once, here: covariances, predictions,
/// tests and statistics all take this snapshot. Later changes of the network are not seen.
///
/// Rows: the residuals of the active factors, factor after factor.
/// Columns: the blocks that are free and have an active factor, in the order of the network.
///
/// A copy shares what it holds, which never changes: any number of threads may read.
class LinearizedNetwork {
 public:
  struct Impl;

  /// The rows of one factor: first, first + 1, .. , first + count - 1.
  struct FactorRows {
    FactorId factor = -1;
    int first = 0;
    int count = 0;
    double weight = 1.0;  ///< rho' of its robust loss; the rows are times its root, see AsRows
  };

  /// What a row is.
  struct Row {
    FactorId factor = -1;
    int residual = 0;     ///< of that factor
    std::string channel;  ///< FactorGroup::Channel; empty without a tag
    std::string axis;
    double t_s = 0.0;  ///< NaN for a factor without an epoch
  };

  /// A factor by itself: its whitened residual without the robust weight and, for each of its
  /// blocks that is free, d residual / d block; of an active factor times its row scale.
  struct Factor {
    Eigen::VectorXd residual;
    std::vector<std::pair<BlockId, Eigen::MatrixXd>> jacobian;
    double weight = 0.0;  ///< in the network: rho' of its loss; 0 when it is not active
  };

  /// `threads` evaluate the factors, and later multiply. Throws InvalidInput naming a factor that
  /// is undefined at the present values.
  explicit LinearizedNetwork(const Network& network, int threads = 1);

  /// The network as if its noise were stated otherwise: row i of r and J times row_scale[i], which
  /// is what a standard deviation 1 / row_scale[i] times as large makes of it. Robust weights stay
  /// those of the noise first stated. Holds r and J once more. Throws InvalidInput for another
  /// number of rows, or a scale that is not positive and finite.
  LinearizedNetwork Scaled(const Eigen::VectorXd& row_scale) const;
  /// The product of all scales so far; ones where there were none.
  const Eigen::VectorXd& row_scale() const;

  Eigen::Index rows() const { return residual().size(); }
  int parameters() const;
  const Eigen::VectorXd& residual() const;

  /// The unknowns in the order of their columns.
  const std::vector<BlockId>& unknowns() const;
  /// First column of a block; -1 where it is none of the unknowns.
  int FirstColumn(BlockId block) const;

  const std::vector<FactorRows>& factors() const;
  /// The rows of a factor; nothing where it is not active. Throws InvalidInput for an unknown id.
  std::optional<FactorRows> RowsOf(FactorId factor) const;
  const FactorGroup& group(FactorId factor) const;
  double t_s(FactorId factor) const;
  /// The name of a row.
  Row RowAt(Eigen::Index row) const;

  /// Derivatives L of the whitened residual of an active factor (its rows x anything) as its rows
  /// have them: times the root of the robust weight and the row scale.
  Eigen::MatrixXd AsRows(const FactorRows& rows, const Eigen::MatrixXd& L) const;

  /// A factor at these values, active or not. One that is not active is evaluated now: throws
  /// InvalidInput where it is undefined.
  Factor FactorAt(FactorId factor) const;

  /// Value of a block at these values.
  template <class Kind>
  ValueOf<Kind> Value(Block<Kind> b) const {
    return ValueOf<Kind>(ViewOf<Kind>(StoredValue(b.id)));
  }
  /// Stored coordinates of a block.
  const double* StoredValue(BlockId block) const;

  /// J X, J^T E.
  Eigen::MatrixXd Times(const Eigen::MatrixXd& X) const;
  Eigen::MatrixXd TransposeTimes(const Eigen::MatrixXd& E) const;

  /// For the sources of this layer.
  const Impl& impl() const { return *impl_; }

 private:
  explicit LinearizedNetwork(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

  std::shared_ptr<const Impl> impl_;
};

}  // namespace dn
