#pragma once

#include <ceres/jet.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <tuple>
#include <type_traits>
#include <vector>

namespace dn {

/// Joint covariance of several blocks, in their order: one pair of triangular solves per tangent
/// coordinate. Rows of held blocks are zero. Throws as Marginals::Covariance.
Eigen::MatrixXd Joint(const Marginals& marginals, const std::vector<BlockId>& blocks);

template <class... Kinds>
auto Joint(const Marginals& marginals, Block<Kinds>... blocks) {
  constexpr int kSize = (Kinds::kTangentSize + ...);
  return Eigen::Matrix<double, kSize, kSize>(Joint(marginals, std::vector<BlockId>{blocks.id...}));
}

/// A function of the unknowns: its value and covariance, in the units of its components.
template <int M>
struct Propagated {
  Eigen::Matrix<double, M, 1> value;
  Eigen::Matrix<double, M, M> covariance;

  Eigen::Matrix<double, M, 1> sigma() const {
    return covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  }
};

namespace internal {

template <class Jet, class Result>
auto AsVector(const Result& result) {
  if constexpr (std::is_convertible_v<Result, Jet>) {
    return Eigen::Matrix<Jet, 1, 1>(Jet(result));
  } else {
    static_assert(Result::ColsAtCompileTime == 1 && Result::RowsAtCompileTime > 0,
                  "Propagate: the function gives a number or a vector of fixed size");
    return Eigen::Matrix<Jet, Result::RowsAtCompileTime, 1>(result);
  }
}

/// Derivatives by stored coordinates, block by block, to those by tangent coordinates.
template <class Stored, class... Kinds>
auto InTangent(const LinearizedNetwork& linearized, const Stored& stored, Block<Kinds>... blocks) {
  constexpr int M = Stored::RowsAtCompileTime;
  Eigen::Matrix<double, M, (Kinds::kTangentSize + ...)> J;
  int from = 0, to = 0;
  const auto lift = [&](int size, int tangent_size, const BlockKind& kind, BlockId block) {
    J.middleCols(to, tangent_size) =
        stored.middleCols(from, size) * PlusJacobian(kind, linearized.StoredValue(block));
    from += size;
    to += tangent_size;
  };
  (lift(Kinds::kSize, Kinds::kTangentSize, KindOf<Kinds>(), blocks.id), ...);
  return J;
}

}  // namespace internal

/// Value of f(blocks...) at the unknowns of the marginals, and its covariance J C J^T, C = Joint.
///
///   const auto distance = Propagate(
///       marginals, [](const auto& p, const auto& q) { return (p - q).norm(); }, p_mb, q_mb);
///
/// f takes what the blocks hold as Network::Add's functions do (a number, a vector, a quaternion, a
/// pose or a view of one's own) with coefficients of a scalar type that differentiates, and returns a number or a vector of fixed size of that type (name the type:
/// an `auto` return of an expression of locals dangles). Differentiated once, at the values.
template <class F, class... Kinds>
auto Propagate(const Marginals& marginals, const F& f, Block<Kinds>... blocks) {
  constexpr int kStored = (Kinds::kSize + ...);
  using Jet = ceres::Jet<double, kStored>;
  const LinearizedNetwork& linearized = marginals.linearized();
  std::array<Jet, static_cast<std::size_t>(kStored)> x;
  std::size_t i = 0;
  const auto fill = [&](const double* value, int size) {
    const Jet* first = x.data() + i;
    for (int k = 0; k < size; ++k, ++i) x[i] = Jet(value[k], static_cast<int>(i));
    return first;
  };
  // In braces: from left to right.
  const std::tuple<decltype(ViewOf<Kinds>(std::declval<const Jet*>()))...> values{ViewOf<Kinds>(
      static_cast<const Jet*>(fill(linearized.StoredValue(blocks.id), Kinds::kSize)))...};
  const auto result = internal::AsVector<Jet>(std::apply(f, values));
  constexpr int kSize = decltype(result)::RowsAtCompileTime;
  Propagated<kSize> propagated;
  Eigen::Matrix<double, kSize, kStored> stored;
  for (int row = 0; row < kSize; ++row) {
    propagated.value[row] = result[row].a;
    stored.row(row) = result[row].v;
  }
  const auto J = internal::InTangent(linearized, stored, blocks...);
  propagated.covariance = J * Joint(marginals, blocks...) * J.transpose();
  return propagated;
}

}  // namespace dn
