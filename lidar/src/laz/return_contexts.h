#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace dn::lidar_internal::laz {

/// Returns the context of a return of POINT10, by the number of returns and the return number.
inline std::size_t ReturnContext(std::size_t returns, std::size_t number) {
  static constexpr std::array<std::array<std::uint8_t, 8>, 8> kContexts{{
      {15, 14, 13, 12, 11, 10, 9, 8},
      {14, 0, 1, 3, 6, 10, 10, 9},
      {13, 1, 2, 4, 7, 11, 11, 10},
      {12, 3, 4, 5, 8, 12, 12, 11},
      {11, 6, 7, 8, 9, 13, 13, 12},
      {10, 10, 11, 12, 13, 14, 14, 13},
      {9, 10, 11, 12, 13, 14, 15, 14},
      {8, 9, 10, 11, 12, 13, 14, 15},
  }};
  return kContexts[returns][number];
}

/// Returns the context of a return of POINT14, by the number of returns and the return number.
inline std::size_t ExtendedReturnContext(std::size_t returns, std::size_t number) {
  static constexpr std::array<std::array<std::uint8_t, 16>, 16> kContexts{{
      {0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5},
      {1, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3},
      {2, 1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3},
      {3, 3, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
      {4, 3, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
      {5, 3, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
      {3, 3, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4},
      {4, 3, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4},
      {4, 3, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4},
      {5, 3, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4},
      {5, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4},
      {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 4},
      {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4, 4},
      {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4},
      {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5},
      {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5},
  }};
  return kContexts[returns][number];
}

/// Returns the context of the height, by the number of returns and the return number: 0 to 7.
inline std::size_t HeightContext(std::size_t returns, std::size_t number) {
  const std::size_t apart = returns > number ? returns - number : number - returns;
  return std::min<std::size_t>(apart, 7);
}

/// Returns the context of a coordinate, by the width of the differences before it. Single returns
/// have the odd contexts.
inline std::size_t WidthContext(std::uint32_t width, std::uint32_t most, bool single) {
  return std::min(width & ~1u, most) + (single ? 1 : 0);
}

}  // namespace dn::lidar_internal::laz
