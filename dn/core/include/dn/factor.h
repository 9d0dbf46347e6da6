#pragma once

#include <dn/autodiff.h>
#include <dn/block.h>
#include <dn/manifold.h>

#include <Eigen/Core>
#include <concepts>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

namespace dn {

/// One edge of the network: a whitened, unitless residual that depends on some blocks.
///
/// A factor never returns a silent zero residual. Evaluate returns false only if the model is
/// undefined.
class FactorBase {
 public:
  virtual ~FactorBase() = default;

  /// Returns the number of residuals.
  virtual int residual_size() const = 0;

  /// Returns the kinds of the blocks, in the order in which Evaluate takes them.
  virtual const std::vector<BlockKind>& block_kinds() const = 0;

  /// Computes the residual r. If J and J[i] are not null, also computes the Jacobian with respect
  /// to the *stored* coordinates of block i, row-major residual_size x stored_size. Only the
  /// product of a Jacobian with the block's PlusJacobian is used, so only this product must be
  /// correct. On entry, r and J are filled with UnwrittenNan(). A value that is not written, or not
  /// finite, ends an adjustment with a message that names the factor. An exception also ends it,
  /// and reaches the caller as InvalidInput.
  virtual bool Evaluate(double const* const* x, double* r, double** J) const = 0;

 protected:
  FactorBase() = default;
  FactorBase(const FactorBase&) = default;
  FactorBase& operator=(const FactorBase&) = default;
};

/// Calls FactorBase::Evaluate after filling r and the Jacobians with UnwrittenNan().
bool EvaluateStored(const FactorBase& factor, double const* const* x, double* r, double** J);

/// Evaluates a factor at x (stored values of its blocks): whitened residual r and, if J is not
/// null, one tangent Jacobian per block. Returns false if the model is undefined.
bool EvaluateInTangent(const FactorBase& factor, const std::vector<const double*>& x,
                       Eigen::VectorXd* r, std::vector<Eigen::MatrixXd>* J = nullptr);

/// Converts the tangent Jacobian J_r_x of a block to stored coordinates, row-major, for
/// FactorBase::Evaluate. x is the block's stored value. J is the destination; nothing is done if it
/// is null.
template <class Matrix>
void PutJacobian(const BlockKind& kind, const double* x, const Eigen::MatrixBase<Matrix>& J_r_x,
                 double* J) {
  if (J == nullptr) return;
  constexpr int kRows = Matrix::RowsAtCompileTime, kCols = Matrix::ColsAtCompileTime;
  if (kind.parametrisation == Parametrisation::kVector) {
    // Eigen requires ColMajor for a column.
    constexpr int kOrder = kCols == 1 ? Eigen::ColMajor : Eigen::RowMajor;
    Eigen::Map<Eigen::Matrix<double, kRows, kCols, kOrder>> out(J, J_r_x.rows(), J_r_x.cols());
    out = J_r_x;
    return;
  }
  if (kind.parametrisation == Parametrisation::kManifold) {
    Eigen::Map<Eigen::Matrix<double, kRows, Eigen::Dynamic, Eigen::RowMajor>> out(J, J_r_x.rows(),
                                                                                  kind.stored_size);
    out.noalias() = J_r_x * TangentLift(kind, x);
    return;
  }
  // PlusJacobian has orthogonal columns of squared length 1/4, so its pseudo-inverse is 4
  // PlusJacobian^T.
  using RowMajor = Eigen::Matrix<double, kRows, 4, Eigen::RowMajor>;
  const Eigen::Matrix<double, 3, 4> lift =
      4.0 * RotationPlusJacobian(kind.parametrisation, x).transpose();
  Eigen::Map<RowMajor> out(J, J_r_x.rows(), 4);
  out.noalias() = J_r_x.template leftCols<3>() * lift;
}

namespace core_internal {

/// Classes whose Evaluate is that of Base.
template <class Derived, class Base>
concept InheritsEvaluate = requires {
  { &Derived::Evaluate } -> std::same_as<decltype(&Base::Evaluate)>;
};

/// Pointer to the stored numbers of a block of this kind.
template <class Kind, class T>
using StoredNumbers = const T*;

/// Classes with the Residual of an AutoFactor, called with numbers of type T.
template <class Derived, class T, class... Kinds>
concept HasResidual = requires(const Derived& factor, StoredNumbers<Kinds, T>... x, T* r) {
  { factor.Residual(x..., r) } -> std::convertible_to<bool>;
};

/// Classes with the Residual of a DynamicAutoFactor, called with numbers of type T.
template <class Derived, class T>
concept HasListResidual = requires(const Derived& factor, const T* const* x, T* r) {
  { factor.Residual(x, r) } -> std::convertible_to<bool>;
};

}  // namespace core_internal

/// Base of a factor with R residuals on blocks of fixed kinds that computes its own Jacobians.
///
/// Derive as `class MyFactor : public Factor<MyFactor, R, Rotation, Vec<3>>` and write Evaluate
/// with Put<I>(x, J, J_r_xi). Add it with Network::Add(factor, block0, block1).
template <class Derived, int R, class... Kinds>
class Factor : public FactorBase {
 public:
  static constexpr int kResiduals = R;
  using Self = Derived;
  using BlockKinds = std::tuple<Kinds...>;

  int residual_size() const final { return R; }
  const std::vector<BlockKind>& block_kinds() const final {
    static const std::vector<BlockKind> kinds{MakeBlockKind<Kinds>()...};
    return kinds;
  }

  /// Not pure virtual, so that the compiler names the function that is missing.
  bool Evaluate(double const* const*, double*, double**) const override {
    static_assert(!core_internal::InheritsEvaluate<Derived, Factor>,
                  "dn: the class derived from Factor needs `bool Evaluate(double const* const* x, "
                  "double* r, double** J) const override`");
    return false;
  }

 protected:
  /// Writes the tangent Jacobian J_r_xI (R x tangent size of block I); does nothing if it was not
  /// requested.
  template <int I, class Matrix>
  static void Put(double const* const* x, double** J, const Eigen::MatrixBase<Matrix>& J_r_xI) {
    constexpr bool kIsBlock = I >= 0 && I < static_cast<int>(sizeof...(Kinds));
    static_assert(kIsBlock, "dn: Put<I>: the factor has no block with this number; the first is 0");
    if constexpr (kIsBlock) {
      using Kind = std::tuple_element_t<I, BlockKinds>;
      static_assert(Matrix::RowsAtCompileTime == R,
                    "dn: Put<I>: the Jacobian needs one row per residual");
      static_assert(
          Matrix::ColsAtCompileTime == Kind::kTangentSize,
          "dn: Put<I>: the Jacobian needs one column per tangent coordinate of the block");
      if (J != nullptr) PutJacobian(MakeBlockKind<Kind>(), x[I], J_r_xI, J[I]);
    }
  }
};

/// Base of a factor that defines only its residual; the Jacobians come from automatic
/// differentiation.
///
/// Derive as `struct MyFactor : dn::AutoFactor<MyFactor, R, Kinds...>` and write `template <class
/// T> bool Residual(const T* x0, ..., T* r) const`. A custom factor needs nothing else.
/// Network::Add also takes a plain function.
template <class Derived, int R, class... Kinds>
class AutoFactor : public Factor<Derived, R, Kinds...> {
 public:
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    static_assert(
        std::is_base_of_v<AutoFactor, Derived>,
        "dn: the first template argument of AutoFactor must be the class that derives from it");
    constexpr bool kHasResidual =
        core_internal::HasResidual<Derived, double, Kinds...> &&
        core_internal::HasResidual<Derived, BlockJet<Kinds::kSize...>, Kinds...>;
    static_assert(kHasResidual,
                  "dn: the class derived from AutoFactor needs a public `template <class T> bool "
                  "Residual(const T* x0, ..., T* r) const` with one x per block");
    if constexpr (kHasResidual) {
      const auto residual = [this](const auto* blocks, auto* out) {
        return this->Call(blocks, out, std::index_sequence_for<Kinds...>{});
      };
      if (J == nullptr) return residual(x, r);
      return Differentiate<R, Kinds::kSize...>(residual, x, r, J);
    }
    return false;
  }

 private:
  template <class T, std::size_t... I>
  bool Call(const T* const* x, T* r, std::index_sequence<I...>) const {
    return static_cast<const Derived&>(*this).Residual(x[I]..., r);
  }
};

/// Base of a factor whose number of blocks is known only at run time, for example for a sum of bias
/// processes.
class DynamicFactor : public FactorBase {
 public:
  int residual_size() const final { return residual_size_; }
  const std::vector<BlockKind>& block_kinds() const final { return kinds_; }

 protected:
  DynamicFactor(int residual_size, std::vector<BlockKind> kinds)
      : residual_size_(residual_size), kinds_(std::move(kinds)) {}

  /// Returns the stored size of each block.
  std::vector<int> stored_sizes() const {
    std::vector<int> sizes;
    for (const BlockKind& kind : kinds_) sizes.push_back(kind.stored_size);
    return sizes;
  }

  /// Writes the tangent Jacobian of block i; does nothing if it was not requested.
  template <class Matrix>
  void Put(int i, double const* const* x, double** J,
           const Eigen::MatrixBase<Matrix>& J_r_xi) const {
    if (J != nullptr) PutJacobian(kinds_[static_cast<std::size_t>(i)], x[i], J_r_xi, J[i]);
  }

 private:
  int residual_size_;
  std::vector<BlockKind> kinds_;
};

/// Base of a DynamicFactor that defines only its residual, which is differentiated automatically.
///
/// Derive as `struct MyFactor : dn::DynamicAutoFactor<MyFactor>` and pass residual size and kinds
/// to its constructor. Write `template <class T> bool Residual(const T* const* x, T* r) const`;
/// x[i] are the numbers of block i.
template <class Derived>
class DynamicAutoFactor : public DynamicFactor {
 public:
  using Self = Derived;

  bool Evaluate(double const* const* x, double* r, double** J) const override {
    static_assert(
        std::is_base_of_v<DynamicAutoFactor, Derived>,
        "dn: the template argument of DynamicAutoFactor must be the class that derives from it");
    constexpr bool kHasResidual = core_internal::HasListResidual<Derived, double> &&
                                  core_internal::HasListResidual<Derived, DynamicJet>;
    static_assert(kHasResidual,
                  "dn: the class derived from DynamicAutoFactor needs a public `template <class T> "
                  "bool Residual(const T* const* x, T* r) const`");
    if constexpr (kHasResidual) {
      const auto residual = [this](const auto* blocks, auto* out) {
        return static_cast<const Derived&>(*this).Residual(blocks, out);
      };
      if (J == nullptr) return residual(x, r);
      return DifferentiateDynamic(residual, stored_sizes(), residual_size(), x, r, J);
    }
    return false;
  }

 protected:
  using DynamicFactor::DynamicFactor;
};

}  // namespace dn
