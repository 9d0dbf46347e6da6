#pragma once

#include <ceres/jet.h>
#include <dn/block.h>

#include <Eigen/Core>
#include <algorithm>
#include <concepts>
#include <type_traits>

namespace dn {

/// Requirements on a user's own manifold as a block kind: kSize stored numbers and kTangentSize
/// tangent coordinates. Covariances refer to the d of its Plus.
///
///   struct Direction {  // a unit vector in the plane, moved by an angle in rad
///     static constexpr int kSize = 2, kTangentSize = 1;
///     template <class T>
///     static void Plus(const T* x, const T* d, T* x_plus_d);                  // Plus(x, 0) = x
///     static void Minus(const double* y, const double* x, double* y_minus_x);  // inverse of Plus
///   };
///
/// If Plus is not a template, the kind also needs PlusJacobian(const double* x, double* J). It
/// writes d Plus / d d at d = 0, row-major kSize x kTangentSize. Network::Value and functions given
/// to Network::Add see a vector by default. Define `using Value` and `template <class T> using
/// View` (constructed from a pointer) for another type.
template <class M>
concept ManifoldKind = requires(const double* x, double* y) {
  { M::kSize } -> std::convertible_to<int>;
  { M::kTangentSize } -> std::convertible_to<int>;
  M::Plus(x, x, y);
  M::Minus(x, x, y);
};

namespace core_internal {

template <class Kind>
concept BuiltInKind = requires {
  Kind::kKind;
};

/// Kinds with a PlusJacobian, their own or by differentiation of Plus.
template <class M>
concept DifferentiableKind = requires(const double* x, double* J) {
  M::PlusJacobian(x, J);
}
|| requires(const ceres::Jet<double, M::kTangentSize>* x,
            ceres::Jet<double, M::kTangentSize>* x_plus_d) {
  M::Plus(x, x, x_plus_d);
};

/// Kinds that Network::AddBlock takes.
template <class Kind>
concept CompleteKind = BuiltInKind<Kind> ||(ManifoldKind<Kind>&& DifferentiableKind<Kind>);

/// Computes d Plus / d d of a manifold whose Plus is a template.
template <class M>
void DifferentiatePlus(const double* x, double* J) {
  using Jet = ceres::Jet<double, M::kTangentSize>;
  Jet x_jet[M::kSize], d[M::kTangentSize], x_plus_d[M::kSize];
  for (int i = 0; i < M::kSize; ++i) x_jet[i] = Jet(x[i]);
  for (int k = 0; k < M::kTangentSize; ++k) d[k] = Jet(0.0, k);
  M::Plus(x_jet, d, x_plus_d);
  for (int i = 0; i < M::kSize; ++i) {
    for (int k = 0; k < M::kTangentSize; ++k) J[i * M::kTangentSize + k] = x_plus_d[i].v[k];
  }
}

template <class M>
void ManifoldPlusJacobian(const double* x, double* J) {
  if constexpr (requires { M::PlusJacobian(x, J); }) {
    M::PlusJacobian(x, J);
  } else {
    DifferentiatePlus<M>(x, J);
  }
}

template <class M>
class FunctionsOfKind final : public ManifoldFunctions {
 public:
  void Plus(const double* x, const double* d, double* x_plus_d) const override {
    M::Plus(x, d, x_plus_d);
  }
  void Minus(const double* y, const double* x, double* y_minus_x) const override {
    M::Minus(y, x, y_minus_x);
  }
  void PlusJacobian(const double* x, double* J) const override { ManifoldPlusJacobian<M>(x, J); }
};

template <class M>
inline constexpr FunctionsOfKind<M> kManifoldFunctions{};

template <class Kind>
struct BlockValue {
  using type = Eigen::Matrix<double, Kind::kSize, 1>;
};
template <class Kind>
requires requires { typename Kind::Value; }
struct BlockValue<Kind> {
  using type = typename Kind::Value;
};

}  // namespace core_internal

/// Returns the run-time description of a block kind: a built-in kind or a ManifoldKind.
template <class Kind>
constexpr BlockKind MakeBlockKind() {
  if constexpr (core_internal::BuiltInKind<Kind>) {
    return Kind::kKind;
  } else if constexpr (core_internal::CompleteKind<Kind>) {
    return {Parametrisation::kManifold, Kind::kSize, Kind::kTangentSize,
            &core_internal::kManifoldFunctions<Kind>};
  } else {
    constexpr bool kIsKind = ManifoldKind<Kind>;
    static_assert(kIsKind,
                  "dn: a block kind needs kSize, kTangentSize, Plus and Minus: see dn/manifold.h");
    constexpr bool kIsDifferentiable = core_internal::DifferentiableKind<Kind>;
    static_assert(!kIsKind || kIsDifferentiable,
                  "dn: a block kind whose Plus takes only doubles needs PlusJacobian: see "
                  "dn/manifold.h");
    return {};
  }
}

/// Type of Network::Value for a block kind.
template <class Kind>
using BlockValue = typename core_internal::BlockValue<Kind>::type;

/// Returns the view of a block with the numbers x that functions given to Network::Add receive.
template <class Kind, class T>
auto MakeView(const T* x) {
  if constexpr (std::is_same_v<BlockValue<Kind>, double>) {
    return *x;
  } else if constexpr (requires { typename Kind::template View<T>; }) {
    return typename Kind::template View<T>(x);
  } else {
    return Eigen::Map<const Eigen::Matrix<T, Kind::kSize, 1>>(x);
  }
}

/// Copies the stored numbers of a value to x.
template <class Kind>
void StoreValue(const BlockValue<Kind>& value, double* x) {
  if constexpr (std::is_same_v<BlockValue<Kind>, double>) {
    *x = value;
  } else if constexpr (requires { value.coeffs().data(); }) {
    std::copy_n(value.coeffs().data(), Kind::kSize, x);
  } else if constexpr (requires { value.Store(x); }) {
    value.Store(x);
  } else {
    std::copy_n(value.data(), Kind::kSize, x);
  }
}

}  // namespace dn
