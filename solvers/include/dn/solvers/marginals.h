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

namespace dn {

/// Columns over the unknowns, block by block (tangent size of the block x columns); zero where a
/// block is missing. All have the same number of columns.
using BlockColumns = std::map<BlockId, Eigen::MatrixXd>;

/// Options of Marginals.
struct MarginalsOptions {
  int threads = 1;  ///< evaluation of the factors, factorisation, selected inverse
  /// A direction of the Jacobi-scaled unknowns (unit vector v, columns of J of unit length) counts
  /// as free when |J v|^2 is below this. A weakly determined direction is far above it.
  double null_tolerance = 1e-16;
  /// Where given, shared with what was solved with it before; see SharedAnalysis.
  std::shared_ptr<SharedAnalysis> analysis = {};

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// Covariances of the unknowns of a network, in the tangent coordinates of its blocks (SI units,
/// rad).
///
///   N = sum_i rho_i' J_i^T J_i,   cov = N^-1
///
/// over the active factors and the blocks that are not held, of a linearised network: of the values
/// when that was made; later changes of the network are not seen. rho' is the derivative of the
/// robust loss, 1 without one. The residuals are whitened: no variance factor is applied.
///
/// N is factored once: N = P^T L L^T P, block-AMD ordering, supernodal. A covariance column then
/// costs one pair of triangular solves; ComputeSelectedInverse gives every diagonal block, and
/// every block within the pattern of L, at about the price of the factorisation.
///
/// A held block has zero covariance. A block that is free but has no active factor has none:
/// asking for it throws RankDeficient.
///
/// Const methods fill a cache: one object is for one thread at a time, but for PatternBlock and
/// PatternOf, which read alone.
///
/// Source: supernodal form of Takahashi, Fagan and Chen (1973), eq. (7) Z = D^-1 L^-1 + (I - L^T)
/// Z.
class Marginals {
 public:
  struct Impl;

  /// Full columns of the covariance matrix: of every unknown with a few blocks.
  class Columns {
   public:
    /// The rows of block b: of SolveColumns, its covariance with those blocks, side by side in
    /// their order (tangent size of b x sum of their tangent sizes).
    Eigen::MatrixXd Rows(BlockId b) const;

   private:
    friend class Marginals;
    std::shared_ptr<const Impl> impl_;
    Eigen::MatrixXd columns_;
  };

  struct Timings {
    double assemble_s = 0.0;  ///< with the evaluation of the factors, where done here
    double analyze_s = 0.0;
    double factor_s = 0.0;
    double rank_s = 0.0;              ///< examination of weak directions; 0 where none was needed
    double selected_inverse_s = 0.0;  ///< 0 until ComputeSelectedInverse
  };

  /// Assembles and factors the normal matrix. Throws RankDeficient naming the unknowns that the
  /// factors leave free, in the words of the blocks' labels, with their weights in each free
  /// direction and the epochs, and what would fix it; InvalidConfig for bad options.
  explicit Marginals(const LinearizedNetwork& linearized, const MarginalsOptions& options = {});
  /// Of the network at its present values. Throws as well as LinearizedNetwork does.
  explicit Marginals(const Network& network, const MarginalsOptions& options = {});
  ~Marginals();
  Marginals(Marginals&&) noexcept;
  Marginals& operator=(Marginals&&) noexcept;

  /// Covariance of a block, tangent size x tangent size.
  Eigen::MatrixXd Covariance(BlockId a) const;
  template <class Kind>
  Eigen::Matrix<double, Kind::kTangentSize, Kind::kTangentSize> Covariance(Block<Kind> a) const {
    return Covariance(a.id);
  }

  /// Standard deviations of a block in its tangent: as Value, a number for a Scalar.
  template <class Kind>
  auto Sigma(Block<Kind> a) const {
    Eigen::Matrix<double, Kind::kTangentSize, 1> sigma = Covariance(a).diagonal().cwiseSqrt();
    if constexpr (std::is_same_v<ValueOf<Kind>, double>) {
      return sigma[0];
    } else {
      return sigma;
    }
  }

  /// Cross covariance E[da db^T] of any two blocks, tangent size of a x tangent size of b. Solves
  /// for the columns of the smaller block unless they, or the selected inverse, are at hand.
  Eigen::MatrixXd Covariance(BlockId a, BlockId b) const;
  template <class KindA, class KindB>
  Eigen::Matrix<double, KindA::kTangentSize, KindB::kTangentSize> Covariance(Block<KindA> a,
                                                                             Block<KindB> b) const {
    return Covariance(a.id, b.id);
  }

  /// The columns of the covariance that belong to some blocks: one pair of triangular solves each.
  Columns SolveColumns(const std::vector<BlockId>& blocks) const;

  /// N^-1 times the right-hand sides; Rows(b) of the result is the part of block b. Rows of held
  /// blocks must not be given. Throws InvalidInput where a size does not fit.
  Columns Solve(const BlockColumns& rhs) const;

  /// The same for right-hand sides over all unknowns: the blocks that are free and have an active
  /// factor, in the order of the network. Throws InvalidInput where the size does not fit.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& rhs) const;

  /// Computes every block of the covariance within the pattern of L.
  void ComputeSelectedInverse();

  /// Covariance of a block from the selected inverse. Throws InvalidInput before
  /// ComputeSelectedInverse.
  Eigen::MatrixXd DiagonalBlock(BlockId a) const;

  /// Cross covariance of two blocks from the selected inverse, nothing where it is outside the
  /// pattern of L. Blocks that share an active factor are always inside. Throws InvalidInput before
  /// ComputeSelectedInverse.
  std::optional<Eigen::MatrixXd> PatternBlock(BlockId a, BlockId b) const;

  /// Covariance of the blocks together, in the order given; zero of held ones. Else as PatternBlock.
  std::optional<Eigen::MatrixXd> PatternOf(std::span<const BlockId> blocks) const;

  /// Normal matrix of a block with all other unknowns eliminated: the inverse of Covariance(a).
  /// Throws InvalidInput for a held block.
  Eigen::MatrixXd ReducedNormal(BlockId a) const;

  /// M E with M = I - J N^-1 J^T: what a fit leaves of the errors E of the rows. Of E ~ N(0, I) it
  /// is a sample of the residuals that the network leaves when its model holds, whatever the
  /// unknowns are. Throws InvalidInput where the size does not fit.
  Eigen::MatrixXd Project(const Eigen::MatrixXd& E) const;
  /// The same in place, of vectors that are the rows of E: quicker, as those of one residual stand
  /// together.
  void ProjectRows(Eigen::MatrixXd* E) const;

  /// The network that the covariances are of.
  const LinearizedNetwork& linearized() const;
  int threads() const;

  /// log |N|, from its factor.
  double LogDeterminant() const;

  int num_parameters() const;    ///< order of N
  long factor_nonzeros() const;  ///< stored entries of L
  const Timings& timings() const;

  /// For the sources of this layer.
  const Impl& impl() const { return *impl_; }

 private:
  std::shared_ptr<Impl> impl_;
};

/// Covariance of one block: Marginals(network).Covariance(block).
template <class Kind>
Eigen::Matrix<double, Kind::kTangentSize, Kind::kTangentSize> MarginalCovariance(
    const Network& network, Block<Kind> block) {
  return Marginals(network).Covariance(block);
}

/// Standard deviations of one block: Marginals(network).Sigma(block).
template <class Kind>
auto MarginalSigma(const Network& network, Block<Kind> block) {
  return Marginals(network).Sigma(block);
}

}  // namespace dn
