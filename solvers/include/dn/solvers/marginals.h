#pragma once

#include <dn/network.h>
#include <dn/solvers/linearized_network.h>
#include <dn/solvers/shared_analysis.h>

#include <Eigen/Core>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

namespace ceres {
class Problem;
}  // namespace ceres

namespace dn {

/// Columns over the unknowns, stored block by block (tangent size of the block x columns). A
/// missing block means zero rows. All entries have the same number of columns.
using BlockColumns = std::map<BlockId, Eigen::MatrixXd>;

/// Options of Marginals.
struct MarginalsOptions {
  /// For the evaluation of the factors, the selected inverse and several right-hand sides.
  int threads = 1;
  /// A direction of the Jacobi-scaled unknowns (unit vector v, columns of J scaled to unit length)
  /// counts as undetermined if |J v|^2 is below this value. A weakly determined direction is far
  /// above it.
  double null_tolerance = 1e-16;
  /// If given, the elimination order and its analysis are shared with other solutions; see
  /// SharedAnalysis.
  std::shared_ptr<SharedAnalysis> analysis = {};

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// Covariances of the unknowns of a network, in the tangent coordinates of its blocks (SI units,
/// rad).
///
///   N = sum_i rho_i' J_i^T J_i,   cov = N^-1
///
/// The sum runs over the active factors of a linearised network, and the unknowns are its blocks
/// that are not constant. The values are those of the linearisation; later changes of the network
/// have no effect. rho' is the derivative of the robust loss, 1 without a loss. The residuals are
/// whitened: no variance factor is applied.
///
/// N is factored once by supernodes: N = P^T L L^T P. The order P of the blocks is the cheaper of
/// minimum degree and nested dissection. A covariance column costs one pair of triangular solves.
/// ComputeSelectedInverse gives every block within the pattern of L for about two factorisations.
///
/// A constant block has zero covariance. A block that is not constant but has no active factor has
/// no covariance: a query for it throws RankDeficient.
///
/// Const methods fill a cache, so an object must be used by one thread at a time. Only
/// SelectedCovariance and JointSelectedCovariance are safe to call concurrently.
///
/// Source: supernodal form of Takahashi, Fagan and Chen (1973), eq. (7) Z = D^-1 L^-1 + (I - L^T)
/// Z.
class Marginals {
 public:
  struct Impl;

  /// Full columns of the covariance matrix: the covariance of every unknown with a few chosen
  /// blocks.
  class Columns {
   public:
    /// Returns the rows of block b. For SolveColumns, they are the cross covariances of b with the
    /// chosen blocks, next to each other in the given order. Their size is tangent size of b x sum
    /// of the tangent sizes.
    Eigen::MatrixXd Rows(BlockId b) const;

   private:
    friend class Marginals;
    std::shared_ptr<const Impl> impl_;
    Eigen::MatrixXd columns_;
  };

  struct Timings {
    double assemble_s = 0.0;  ///< includes the evaluation of the factors if this object did it
    double analyze_s = 0.0;
    double factor_s = 0.0;
    double rank_s = 0.0;  ///< examination of weakly determined directions; 0 if it was not needed
    double selected_inverse_s = 0.0;  ///< 0 before ComputeSelectedInverse
  };

  /// Assembles and factors the normal matrix. Throws RankDeficient if the factors leave unknowns
  /// undetermined. The message names the unknowns by the labels of their blocks, with their epochs
  /// and their weights in each free direction. It also says what would determine them. Throws
  /// InvalidConfig for bad options.
  explicit Marginals(const LinearizedNetwork& linearized, const MarginalsOptions& options = {});
  /// Linearises the network at its current values first. Also throws what LinearizedNetwork throws.
  explicit Marginals(const Network& network, const MarginalsOptions& options = {});
  /// Linearises a problem of Ceres at its present values (see ProblemNetwork in dn/ceres.h). Serves
  /// as ceres::Covariance does, for every pair of parameter blocks at the cost of one
  /// factorisation:
  ///
  ///   const dn::Marginals marginals(problem);
  ///   const Eigen::MatrixXd covariance = marginals.Covariance(camera, point);
  ///
  /// The covariances are in the tangent spaces of the manifolds. Also throws InvalidInput naming a
  /// residual block whose cost function fails. The problem must outlive this object.
  explicit Marginals(const ceres::Problem& problem, const MarginalsOptions& options = {});
  ~Marginals();
  Marginals(Marginals&&) noexcept;
  Marginals& operator=(Marginals&&) noexcept;

  /// Returns the covariance of a block, tangent size x tangent size.
  Eigen::MatrixXd Covariance(BlockId a) const;
  template <class Kind>
  Eigen::Matrix<double, Kind::kTangentSize, Kind::kTangentSize> Covariance(Block<Kind> a) const {
    return Covariance(linearized().Id(a));
  }

  /// Returns the standard deviations of a block in its tangent coordinates; a plain number for a
  /// Scalar, like Value.
  template <class Kind>
  auto Sigma(Block<Kind> a) const {
    Eigen::Matrix<double, Kind::kTangentSize, 1> sigma = Covariance(a).diagonal().cwiseSqrt();
    if constexpr (std::is_same_v<BlockValue<Kind>, double>) {
      return sigma[0];
    } else {
      return sigma;
    }
  }

  /// Returns the cross covariance E[da db^T] of any two blocks, tangent size of a x tangent size of
  /// b. Solves for the columns of the smaller block unless they, or the selected inverse, are
  /// available.
  Eigen::MatrixXd Covariance(BlockId a, BlockId b) const;
  template <class KindA, class KindB>
  Eigen::Matrix<double, KindA::kTangentSize, KindB::kTangentSize> Covariance(Block<KindA> a,
                                                                             Block<KindB> b) const {
    return Covariance(linearized().Id(a), linearized().Id(b));
  }

  /// Returns the covariance of one or two parameter blocks of a ceres::Problem. Throws InvalidInput
  /// for an address that the problem did not have.
  Eigen::MatrixXd Covariance(const double* a) const { return Covariance(Find(a)); }
  Eigen::MatrixXd Covariance(const double* a, const double* b) const {
    return Covariance(Find(a), Find(b));
  }
  /// Returns the block of a parameter block of a ceres::Problem.
  BlockId Find(const double* parameter_block) const;

  /// Returns the covariance columns of some blocks: one pair of triangular solves per column.
  Columns SolveColumns(const std::vector<BlockId>& blocks) const;

  /// Returns N^-1 times the right-hand sides; Rows(b) of the result is the part of block b.
  /// Constant blocks must not appear in `rhs`. Throws InvalidInput if a size does not fit.
  Columns Solve(const BlockColumns& rhs) const;

  /// Returns N^-1 times right-hand sides over all unknowns: the blocks that are not constant and
  /// have an active factor, in the order of the network. Throws InvalidInput if the size does not
  /// fit.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& rhs) const;

  /// Computes every block of the covariance within the pattern of L.
  void ComputeSelectedInverse();

  /// Returns the covariance of a block from the selected inverse. Throws InvalidInput before
  /// ComputeSelectedInverse.
  Eigen::MatrixXd DiagonalBlock(BlockId a) const;

  /// Returns the cross covariance of two blocks from the selected inverse, or nullopt if it is
  /// outside the pattern of L. Blocks that share an active factor are always inside. Throws
  /// InvalidInput before ComputeSelectedInverse.
  std::optional<Eigen::MatrixXd> SelectedCovariance(BlockId a, BlockId b) const;

  /// Returns the joint covariance of the blocks, in the order given, with zeros for constant
  /// blocks. Returns nullopt and throws as SelectedCovariance does.
  std::optional<Eigen::MatrixXd> JointSelectedCovariance(std::span<const BlockId> blocks) const;

  /// Returns the normal matrix of a block with all other unknowns eliminated: the inverse of
  /// Covariance(a). Throws InvalidInput for a constant block.
  Eigen::MatrixXd ReducedNormal(BlockId a) const;

  /// Returns M E with M = I - J N^-1 J^T, which turns errors E of the rows into residuals after the
  /// fit. For E ~ N(0, I) the result is a sample of the residuals under a correct model, whatever
  /// the true unknowns are. Throws InvalidInput if the size does not fit.
  Eigen::MatrixXd Project(const Eigen::MatrixXd& E) const;
  /// Applies M in place to vectors that are stored as the rows of E. This is faster than Project
  /// because the entries of one residual are contiguous.
  void ProjectRows(Eigen::MatrixXd* E) const;

  /// Returns the linearised network of these covariances.
  const LinearizedNetwork& linearized() const;
  int threads() const;

  /// Returns log |N|, from its Cholesky factor.
  double LogDeterminant() const;

  int num_parameters() const;    ///< order of N
  long factor_nonzeros() const;  ///< number of stored entries of L
  const Timings& timings() const;

  /// Internal: only the sources of this layer use it.
  const Impl& impl() const { return *impl_; }

 private:
  std::shared_ptr<Impl> impl_;
};

/// Returns the covariance of one block: Marginals(network).Covariance(block).
template <class Kind>
Eigen::Matrix<double, Kind::kTangentSize, Kind::kTangentSize> MarginalCovariance(
    const Network& network, Block<Kind> block) {
  return Marginals(network).Covariance(block);
}

/// Returns the standard deviations of one block: Marginals(network).Sigma(block).
template <class Kind>
auto MarginalSigma(const Network& network, Block<Kind> block) {
  return Marginals(network).Sigma(block);
}

}  // namespace dn
