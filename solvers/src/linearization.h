#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace dn {

inline std::size_t AsSize(int i) { return static_cast<std::size_t>(i); }

/// The unknowns of a network in one vector: the blocks that are free and have an active factor, in
/// the order of the network.
struct UnknownLayout {
  std::vector<BlockId> blocks;   ///< by position
  std::vector<int> position_of;  ///< by BlockId; -1 for a block that is not an unknown
  std::vector<int> offset;       ///< of each position's tangent coordinates, and the total at last

  explicit UnknownLayout(const Network& network);
  int num_blocks() const { return static_cast<int>(blocks.size()); }
  int size() const { return offset.back(); }
  int size_of(int position) const {
    const auto p = static_cast<std::size_t>(position);
    return offset[p + 1] - offset[p];
  }
};

/// The whitened Jacobian of every active factor in tangent coordinates, times the square root of
/// rho': robust weights of first order, as Ceres applies them.
class Linearization {
 public:
  /// The Jacobian of one factor: rows x (its unknown blocks side by side), column-major.
  struct Edge {
    int rows = 0;
    int cols = 0;
    std::size_t data = 0;  ///< into the store of Jacobians
    int first_row = 0;     ///< into the residual
    FactorId factor = -1;
    std::size_t first_block = 0;  ///< into the list of positions
    int num_blocks = 0;
    double weight = 1.0;  ///< rho'
    double rho = 0.0;     ///< rho(|r|^2); NaN where the factor is undefined
  };

  /// Throws InvalidInput naming a factor that is undefined at the current values.
  Linearization(const Network& network, const UnknownLayout& layout, int threads);
  /// Room for the Jacobians of this layout, which Evaluate fills.
  Linearization(const Network& network, const UnknownLayout& layout);
  /// Another one with its rows times row_scale; layout is equal to the other's.
  Linearization(const Linearization& other, const UnknownLayout& layout,
                const Eigen::VectorXd& row_scale);
  Linearization(const Linearization&) = delete;
  Linearization& operator=(const Linearization&) = delete;

  /// Anew, at the current values of the network of the constructor. False where a factor is
  /// undefined.
  [[nodiscard]] bool Evaluate(const Network& network, int threads);

  /// 1/2 sum rho(|r|^2).
  double cost() const;

  const std::vector<Edge>& edges() const { return edges_; }
  /// Whitened residuals, with the same weights.
  const Eigen::VectorXd& residual() const { return residual_; }
  const int* positions(const Edge& edge) const { return positions_.data() + edge.first_block; }
  Eigen::Map<const Eigen::MatrixXd> jacobian(const Edge& edge) const {
    return {values_.data() + edge.data, edge.rows, edge.cols};
  }

  /// Adds J X of one factor to `out`, edge.rows x k; X: unknowns x k.
  void AddProduct(const Edge& edge, const Eigen::MatrixXd& X,
                  Eigen::Ref<Eigen::MatrixXd> out) const;

  /// J^T E; E: rows x k.
  Eigen::MatrixXd TransposeTimes(const Eigen::MatrixXd& E) const;

  /// Triangular factor of J X, which has the singular values of J X; X: unknowns x k.
  Eigen::MatrixXd TriangularFactorOfProduct(const Eigen::MatrixXd& X) const;

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
