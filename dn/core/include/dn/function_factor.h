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
constexpr bool IsEigen() {
  return std::is_base_of_v<Eigen::EigenBase<Result>, Result>;
}

template <class Result>
constexpr bool IsExpression() {
  return !std::is_base_of_v<Eigen::PlainObjectBase<Result>, Result>;
}

/// How a function fits the blocks that it is given.
enum class FunctionFit {
  kGood,
  kOtherBlocks,
  kMutable,
  kExpression,
  kOtherShape,
  kNotDifferentiable,
};

/// Judges the result of a function of blocks with numbers of type T.
template <class T, class Result>
constexpr FunctionFit ResultFit() {
  if constexpr (IsOptional<Result>::value) {
    return ResultFit<T, typename Result::value_type>();
  } else if constexpr (IsEigen<Result>()) {
    if (IsExpression<Result>()) return FunctionFit::kExpression;
    if (Result::SizeAtCompileTime == Eigen::Dynamic || Result::ColsAtCompileTime != 1) {
      return FunctionFit::kOtherShape;
    }
    return std::is_same_v<typename Result::Scalar, T> ? FunctionFit::kGood
                                                      : FunctionFit::kNotDifferentiable;
  } else {
    if (std::is_same_v<Result, T>) return FunctionFit::kGood;
    return std::is_arithmetic_v<Result> ? FunctionFit::kNotDifferentiable
                                        : FunctionFit::kOtherShape;
  }
}

/// Returns the number of residuals in a result that fits.
template <class Result>
constexpr int ResultSize() {
  if constexpr (IsOptional<Result>::value) {
    return ResultSize<typename Result::value_type>();
  } else if constexpr (IsEigen<Result>()) {
    return Result::SizeAtCompileTime;
  } else {
    return 1;
  }
}

/// Stops the compiler with a sentence about the function. Its callers instantiate nothing that
/// needs a good function, so that this sentence is the only error.
template <FunctionFit kFit, int kReturned, int kNoise>
void ExpectFit() {
  static_assert(kFit != FunctionFit::kOtherBlocks,
                "dn: the function cannot be called with these blocks: it takes one const auto& per "
                "block in their order, or one for a whole list of blocks");
  static_assert(kFit != FunctionFit::kMutable,
                "dn: the function changes its own state, which a factor must not: omit `mutable`");
  static_assert(kFit != FunctionFit::kExpression,
                "dn: the function returns an Eigen expression, which may refer to values that no "
                "longer exist: end it with .eval()");
  static_assert(kFit != FunctionFit::kOtherShape,
                "dn: the function must return a number or an Eigen vector of fixed size");
  static_assert(kFit != FunctionFit::kNotDifferentiable,
                "dn: the result of the function does not have the number type of its blocks, so it "
                "cannot be differentiated: take const auto&, and do not convert it to double");
  static_assert(kReturned == kNoise,
                "dn: the function returns a different number of residuals than its Noise<R> has");
}

/// Judges a function whose arguments are views with numbers of type T.
template <class T, class Function, class... Views>
struct FunctionCheck {
  using Result = std::remove_cvref_t<typename std::conditional_t<
      std::is_invocable_v<const Function&, Views...>, std::invoke_result<const Function&, Views...>,
      std::type_identity<void>>::type>;

  static constexpr FunctionFit Fit() {
    if constexpr (std::is_invocable_v<const Function&, Views...>) {
      return ResultFit<T, Result>();
    } else {
      return std::is_invocable_v<Function&, Views...> ? FunctionFit::kMutable
                                                      : FunctionFit::kOtherBlocks;
    }
  }

  /// Returns the number of residuals, or R if the function does not fit for another reason.
  template <int R>
  static constexpr int Size() {
    if constexpr (Fit() == FunctionFit::kGood) {
      return ResultSize<Result>();
    } else {
      return R;
    }
  }

  template <int R>
  static constexpr bool kGood = (Fit() == FunctionFit::kGood) && (Size<R>() == R);
};

/// The view of a block of this kind with numbers of type T.
template <class Kind, class T>
using BlockView = decltype(MakeView<Kind>(std::declval<const T*>()));

template <class Function, class... Kinds>
using CheckFunction = FunctionCheck<BlockJet<Kinds::kSize...>, Function,
                                    BlockView<Kinds, BlockJet<Kinds::kSize...>>...>;

template <class Function, class Kind>
using CheckListFunction = FunctionCheck<DynamicJet, Function, const BlockViews<Kind, DynamicJet>&>;

/// Copies a function's result to the residuals before whitening; returns false if it is
/// std::nullopt.
template <int R, class T, class Result>
bool Unpack(const Result& result, std::array<T, R>* f) {
  if constexpr (IsOptional<Result>::value) {
    return result.has_value() && Unpack<R, T>(*result, f);
  } else if constexpr (IsEigen<Result>()) {
    for (int i = 0; i < R; ++i) (*f)[static_cast<std::size_t>(i)] = result[i];
    return true;
  } else {
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
 public:
  FunctionFactor(Function function, const Noise<R>& noise)
      : function_(std::move(function)), W_(noise.sqrt_information()) {
    using Check = core_internal::CheckFunction<Function, Kinds...>;
    core_internal::ExpectFit<Check::Fit(), Check::template Size<R>(), R>();
  }

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
 public:
  ListFunctionFactor(Function function, const Noise<R>& noise, std::size_t num_blocks)
      : DynamicFactor(R, std::vector<BlockKind>(num_blocks, MakeBlockKind<Kind>())),
        function_(std::move(function)),
        W_(noise.sqrt_information()) {
    using Check = core_internal::CheckListFunction<Function, Kind>;
    core_internal::ExpectFit<Check::Fit(), Check::template Size<R>(), R>();
  }

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
