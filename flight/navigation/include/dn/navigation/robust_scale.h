#pragma once

#include <dn/median.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace dn {

/// Norm of a standardised 3-vector that a good measurement exceeds with the probability of five
/// sigmas of a normal variable, 1 in 1.7 million.
constexpr double kOutlierNorm = 5.6;
/// Like kOutlierNorm, but for point pairs. A flight has so many pairs that it can lose a share of
/// 6.3e-5 of the good ones (four sigmas of a normal variable).
constexpr double kOutlierPairNorm = 4.68;
/// Like kOutlierPairNorm, for a single coordinate.
constexpr double kOutlierScalar = 4.0;

/// Returns the variance of whitened 3-vectors from the median of their squared norms, at least 1.
/// Outliers in less than half of them have little influence. norm2 must not be empty.
inline double RobustVariance(std::vector<double> norm2) {
  constexpr double kMedianChi2Of3 = 2.366;
  return std::max(1.0, Median(std::move(norm2)) / kMedianChi2Of3);
}

/// Returns the same for single coordinates, from their squares.
inline double RobustScalarVariance(std::vector<double> squares) {
  constexpr double kMedianChi2Of1 = 0.4549;
  return std::max(1.0, Median(std::move(squares)) / kMedianChi2Of1);
}

}  // namespace dn
