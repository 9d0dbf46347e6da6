#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace dn {

inline std::size_t AsSize(int i) { return static_cast<std::size_t>(i); }

/// The unknowns of a network as one vector: the blocks that are not constant and have an active
/// factor, in the order of the network.
struct UnknownLayout {
  std::vector<BlockId> blocks;  ///< block at each position
  /// Position of each BlockId; -1 for a block that is not an unknown.
  std::vector<int> block_position;
  /// First tangent coordinate of each position, followed by the total number of coordinates.
  std::vector<int> offset;

  explicit UnknownLayout(const Network& network);
  int num_blocks() const { return static_cast<int>(blocks.size()); }
  int size() const { return offset.back(); }
  int block_size(int position) const {
    const auto p = static_cast<std::size_t>(position);
    return offset[p + 1] - offset[p];
  }
};

/// Whitened Jacobians of all active factors in tangent coordinates, times the square root of rho'.
/// These are first-order robust weights, as in Ceres.
class Linearization {
 public:
  /// Jacobian of one factor: rows x (its unknown blocks next to each other), column-major.
  struct Edge {
    int rows = 0;
    int cols = 0;
    std::size_t data = 0;  ///< offset in the store of Jacobians
    int first_row = 0;     ///< offset in the residual vector
    FactorId factor = -1;
    std::size_t first_block = 0;  ///< offset in the list of positions
    int num_blocks = 0;
    double weight = 1.0;  ///< rho'
    double rho = 0.0;     ///< rho(|r|^2); NaN if the factor is undefined
  };

  /// Evaluates all factors. Throws InvalidInput naming a factor that is undefined at the current
  /// values.
  Linearization(const Network& network, const UnknownLayout& layout, int threads);
  /// Allocates the Jacobians of this layout; Evaluate fills them.
  Linearization(const Network& network, const UnknownLayout& layout);
  /// Copies another linearisation with its rows multiplied by row_scale; `layout` must equal that
  /// of `other`.
  Linearization(const Linearization& other, const UnknownLayout& layout,
                const Eigen::VectorXd& row_scale);
  Linearization(const Linearization&) = delete;
  Linearization& operator=(const Linearization&) = delete;

  /// Evaluates all factors at the current values of the network that was given to the constructor.
  /// Returns false if a factor is undefined.
  [[nodiscard]] bool Evaluate(const Network& network, int threads);

  /// Returns 1/2 sum rho(|r|^2).
  double cost() const;

  const std::vector<Edge>& edges() const { return edges_; }
  /// Returns the whitened residuals, with the same robust weights as the Jacobians.
  const Eigen::VectorXd& residual() const { return residual_; }
  const int* positions(const Edge& edge) const { return positions_.data() + edge.first_block; }
  Eigen::Map<const Eigen::MatrixXd> jacobian(const Edge& edge) const {
    return {values_.data() + edge.data, edge.rows, edge.cols};
  }

  /// Adds J X of one factor to `out` (edge.rows x k); X is unknowns x k.
  void AddProduct(const Edge& edge, const Eigen::MatrixXd& X,
                  Eigen::Ref<Eigen::MatrixXd> out) const;

  /// Returns J^T E; E is rows x k.
  Eigen::MatrixXd TransposeTimes(const Eigen::MatrixXd& E) const;

  /// Returns the triangular factor R of J X, which has the singular values of J X; X is unknowns x
  /// k.
  Eigen::MatrixXd ProductTriangularFactor(const Eigen::MatrixXd& X) const;

 private:
  void Reserve(const Network& network);
  void EvaluateEdge(const Network& network, Edge* edge);

  const UnknownLayout& layout_;
  std::vector<Edge> edges_;
  std::vector<int> positions_;
  std::vector<double> values_;
  Eigen::VectorXd residual_;
};

}  // namespace dn
