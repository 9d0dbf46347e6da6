#pragma once

#include <dn/autodiff.h>
#include <dn/function_factor.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>
#include <vector>

namespace dn {

/// Returns the joint covariance of several blocks, in the order given. It costs one pair of
/// triangular solves per tangent coordinate. Rows of constant blocks are zero. Throws as
/// Marginals::Covariance does.
Eigen::MatrixXd Joint(const Marginals& marginals, const std::vector<BlockId>& blocks);

template <class... Kinds>
auto Joint(const Marginals& marginals, Block<Kinds>... blocks) {
  constexpr int kSize = (Kinds::kTangentSize + ...);
  return Eigen::Matrix<double, kSize, kSize>(
      Joint(marginals, std::vector<BlockId>{marginals.linearized().Id(blocks)...}));
}

/// Value and covariance of a function of the unknowns, in the units of its components.
template <int M>
struct Propagated {
  Eigen::Matrix<double, M, 1> value;
  Eigen::Matrix<double, M, M> covariance;

  Eigen::Matrix<double, M, 1> sigma() const {
    return covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  }
};

namespace solvers_internal {

template <class Jet, class Result>
auto AsVector(const Result& result) {
  return Eigen::Matrix<Jet, core_internal::ResultSize<Result>(), 1>(result);
}

/// Returns how a function fits Propagate, which takes no std::optional.
template <class F, class... Kinds>
constexpr core_internal::FunctionFit PropagatedFit() {
  using Check = core_internal::CheckFunction<F, Kinds...>;
  return core_internal::IsOptional<typename Check::Result>::value
             ? core_internal::FunctionFit::kOtherShape
             : Check::Fit();
}

/// Returns f of the blocks at x as a vector.
template <class... Kinds, class F, class T, std::size_t... I>
auto Apply(const F& f, const T* const* x, std::index_sequence<I...>) {
  return AsVector<T>(f(MakeView<Kinds>(x[I])...));
}

template <class F, class... Kinds>
auto PropagateGood(const Marginals& marginals, const F& f, Block<Kinds>... blocks) {
  constexpr auto kAll = std::index_sequence_for<Kinds...>{};
  using Jet = BlockJet<Kinds::kSize...>;
  using Result = decltype(Apply<Kinds...>(f, std::declval<const Jet* const*>(), kAll));
  constexpr int kSize = Result::RowsAtCompileTime;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const std::array x{marginals.linearized().StoredValue(marginals.linearized().Id(blocks))...};
  std::array stored{RowMajor(kSize, Kinds::kSize)...};
  std::array<double*, sizeof...(Kinds)> wanted;
  std::transform(stored.begin(), stored.end(), wanted.begin(), [](auto& J) { return J.data(); });
  Propagated<kSize> propagated;
  Differentiate<kSize, Kinds::kSize...>(
      [&](const Jet* const* at, Jet* out) {
        const Result result = Apply<Kinds...>(f, at, kAll);
        std::copy_n(result.data(), kSize, out);
        return true;
      },
      x.data(), propagated.value.data(), wanted.data());

  Eigen::Matrix<double, kSize, (Kinds::kTangentSize + ...)> J;
  std::size_t block = 0;
  int column = 0;
  const auto lift = [&](const BlockKind& kind) {
    StoredToTangent(kind, x[block], stored[block], J.middleCols(column, kind.tangent_size));
    column += kind.tangent_size;
    ++block;
  };
  (lift(MakeBlockKind<Kinds>()), ...);
  propagated.covariance = J * Joint(marginals, blocks...) * J.transpose();
  return propagated;
}

}  // namespace solvers_internal

/// Returns the value of f(blocks...) at the values of the marginals, and its covariance J C J^T
/// with C = Joint.
///
///   const auto distance = Propagate(
///       marginals, [](const auto& p, const auto& q) { return (p - q).norm(); }, p_mb, q_mb);
///
/// f takes the values of the blocks in the same form as functions given to Network::Add. Each is a
/// number, a vector, a quaternion, a pose or a user's own view. The coefficients are of a scalar
/// type for automatic differentiation. f returns a number or a vector of fixed size of that type;
/// an Eigen expression must end with .eval(). f is differentiated once, at the current values.
template <class F, class... Kinds>
auto Propagate(const Marginals& marginals, const F& f, Block<Kinds>... blocks) {
  constexpr auto kFit = solvers_internal::PropagatedFit<F, Kinds...>();
  core_internal::ExpectFit<kFit, 0, 0>();
  if constexpr (kFit == core_internal::FunctionFit::kGood) {
    return solvers_internal::PropagateGood(marginals, f, blocks...);
  } else {
    return Propagated<1>{};
  }
}

}  // namespace dn
