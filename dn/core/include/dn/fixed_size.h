#pragma once

#include <dn/error.h>

#include <Eigen/Core>
#include <string>
#include <type_traits>

namespace dn::core_internal {

/// Returns an Eigen expression as a matrix of fixed size; a row counts as a vector. An expression
/// of another fixed size does not compile, and one of another dynamic size throws InvalidInput
/// that opens with `what`.
template <int kRows, int kCols, class Derived>
Eigen::Matrix<double, kRows, kCols> FixedSize(const Eigen::MatrixBase<Derived>& given,
                                              const std::string& what) {
  constexpr bool kVectors = kCols == 1 && Derived::IsVectorAtCompileTime;
  constexpr auto kFits = [](int size, int expected) {
    return size == Eigen::Dynamic || size == expected;
  };
  constexpr bool kSameSize = kVectors ? kFits(Derived::SizeAtCompileTime, kRows)
                                      : kFits(Derived::RowsAtCompileTime, kRows) &&
                                            kFits(Derived::ColsAtCompileTime, kCols);
  constexpr bool kDoubles = std::is_same_v<typename Derived::Scalar, double>;
  static_assert(kSameSize, "dn: the vector or matrix has another size than its block or noise");
  static_assert(kDoubles, "dn: the numbers must be of type double: use .cast<double>()");
  if constexpr (kSameSize && kDoubles) {
    const bool fits =
        kVectors ? given.size() == kRows : given.rows() == kRows && given.cols() == kCols;
    if (!fits) {
      throw InvalidInput(what + " has size " + std::to_string(given.rows()) + " x " +
                         std::to_string(given.cols()) + ", must be " + std::to_string(kRows) +
                         " x " + std::to_string(kCols));
    }
    return given;
  }
  return {};
}

}  // namespace dn::core_internal
