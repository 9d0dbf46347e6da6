#pragma once

#include <cstddef>
#include <memory>

namespace dn {

/// An array without numbers yet. Where it is large, the system is asked for huge pages: it hands out
/// and clears one of them where it would else do so with 512.
std::unique_ptr<double[]> NewArray(std::size_t size);

struct FreeZeros {
  void operator()(double* array) const noexcept;
};

/// An array of zeros, which are not written where what the system hands out is cleared. Throws
/// std::bad_alloc.
std::unique_ptr<double[], FreeZeros> NewZeros(std::size_t size);

}  // namespace dn
