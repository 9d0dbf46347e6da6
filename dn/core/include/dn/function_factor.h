#pragma once

#include <dn/factor.h>
#include <dn/noise.h>

#include <Eigen/Core>
#include <array>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace dn {

/// View of a std::vector of blocks of one kind, as passed to a function: size(), and [i], which is
/// block i as MakeView presents it.
template <class Kind, class T>
class BlockViews {
 public:
  BlockViews(const T* const* x, int size) : x_(x), size_(size) {}
  int size() const { return size_; }
  auto operator[](int i) const { return MakeView<Kind, T>(x_[i]); }

 private:
  const T* const* x_;
  int size_;
};

namespace core_internal {

template <class Result>
struct IsOptional : std::false_type {};
template <class Result>
struct IsOptional<std::optional<Result>> : std::true_type {};

template <class Result>
constexpr bool IsExpression() {
  return !std::is_base_of_v<Eigen::PlainObjectBase<Result>, Result>;
}

/// Compares the two sizes as template arguments, so that the compiler's message shows both.
template <int kReturned, int kNoise>
struct ResidualSizes {
  static_assert(
      kReturned == kNoise,
      "Network::Add: the function returns a different number of residuals than its Noise<R> "
      "has: see ResidualSizes<returned, R> in this message");
  static constexpr bool kEqual = kReturned == kNoise;
};

/// Copies a function's result to the residuals before whitening; returns false if it is
/// std::nullopt.
template <int R, class T, class Result>
bool Unpack(const Result& result, std::array<T, R>* f) {
  if constexpr (IsOptional<Result>::value) {
    return result.has_value() && Unpack<R, T>(*result, f);
  } else if constexpr (std::is_base_of_v<Eigen::EigenBase<Result>, Result>) {
    static_assert(
        !IsExpression<Result>(),
        "Network::Add: the function returns an Eigen expression, which may refer to values "
        "that no longer exist: end it with .eval()");
    static_assert(std::is_same_v<typename Result::Scalar, T>,
                  "Network::Add: the result of the function does not have the scalar type of its "
                  "blocks, so it cannot be differentiated: do not convert it to double");
    static_assert(Result::SizeAtCompileTime != Eigen::Dynamic && Result::ColsAtCompileTime == 1,
                  "Network::Add: the function must return a number or a vector of fixed size");
    static_assert(ResidualSizes<Result::SizeAtCompileTime, R>::kEqual);
    for (int i = 0; i < R; ++i) (*f)[static_cast<std::size_t>(i)] = result[i];
    return true;
  } else {
    static_assert(
        std::is_convertible_v<Result, T>,
        "Network::Add: the function must return a number or a vector of fixed size (Eigen, "
        "or std::optional of one)");
    static_assert(std::is_same_v<Result, T>,
                  "Network::Add: the result of the function does not have the scalar type of its "
                  "blocks, so it cannot be differentiated: do not convert it to double");
    static_assert(ResidualSizes<1, R>::kEqual);
    (*f)[0] = result;
    return true;
  }
}

/// Computes r = W result, skipping the zeros of W.
template <int R, class T, class Result>
bool Whiten(const Eigen::Matrix<double, R, R>& W, const Result& result, T* r) {
  std::array<T, R> f;
  if (!Unpack<R, T>(result, &f)) return false;
  for (int i = 0; i < R; ++i) {
    r[i] = T(0.0);
    for (int j = 0; j < R; ++j) {
      if (W(i, j) != 0.0) r[i] += W(i, j) * f[static_cast<std::size_t>(j)];
    }
  }
  return true;
}

}  // namespace core_internal

/// Factor of a function: r = W f(blocks), differentiated automatically. See Network::Add.
template <class Function, int R, class... Kinds>
class FunctionFactor final : public Factor<FunctionFactor<Function, R, Kinds...>, R, Kinds...> {
  static_assert(std::is_invocable_v<const Function&, decltype(MakeView<Kinds>(
                                                         static_cast<const double*>(nullptr)))...>,
                "Network::Add: the function cannot be called with these blocks: it takes one const "
                "auto& per block, in their order");

 public:
  FunctionFactor(Function function, const Noise<R>& noise)
      : function_(std::move(function)), W_(noise.sqrt_information()) {}

  bool Evaluate(double const* const* x, double* r, double** J) const override {
    const auto residual = [this](const auto* blocks, auto* out) {
      return this->Residual(blocks, out, std::index_sequence_for<Kinds...>{});
    };
    if (J == nullptr) return residual(x, r);
    return Differentiate<R, Kinds::kSize...>(residual, x, r, J);
  }

 private:
  template <class T, std::size_t... I>
  bool Residual(const T* const* x, T* r, std::index_sequence<I...>) const {
    return core_internal::Whiten<R, T>(W_, function_(MakeView<Kinds>(x[I])...), r);
  }

  Function function_;
  Eigen::Matrix<double, R, R> W_;
};

/// Factor of a function of any number of blocks of one kind; the function takes their BlockViews.
template <class Function, int R, class Kind>
class ListFunctionFactor final : public DynamicFactor {
  static_assert(std::is_invocable_v<const Function&, const BlockViews<Kind, double>&>,
                "Network::Add: the function must take the list of blocks as one const auto&");

 public:
  ListFunctionFactor(Function function, const Noise<R>& noise, std::size_t num_blocks)
      : DynamicFactor(R, std::vector<BlockKind>(num_blocks, MakeBlockKind<Kind>())),
        function_(std::move(function)),
        W_(noise.sqrt_information()) {}

  bool Evaluate(double const* const* x, double* r, double** J) const override {
    const auto n = static_cast<int>(block_kinds().size());
    const auto residual = [this, n]<class T>(const T* const* blocks, T* out) {
      return core_internal::Whiten<R, T>(W_, function_(BlockViews<Kind, T>(blocks, n)), out);
    };
    if (J == nullptr) return residual(x, r);
    return DifferentiateDynamic(residual, stored_sizes(), R, x, r, J);
  }

 private:
  Function function_;
  Eigen::Matrix<double, R, R> W_;
};

}  // namespace dn
