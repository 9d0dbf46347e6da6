#include "large_array.h"

#include <sys/mman.h>

#include <cstdint>

namespace dn {
namespace {

constexpr std::size_t kLargeBytes = std::size_t{4} << 20;
constexpr std::uintptr_t kPageBytes = 4096;

}  // namespace

std::unique_ptr<double[]> NewArray(std::size_t size) {
  std::unique_ptr<double[]> array(new double[size]);
#ifdef MADV_HUGEPAGE
  if (size * sizeof(double) >= kLargeBytes) {
    const auto first = reinterpret_cast<std::uintptr_t>(array.get());
    const std::uintptr_t page = (first + kPageBytes - 1) / kPageBytes * kPageBytes;
    const std::uintptr_t past = (first + size * sizeof(double)) / kPageBytes * kPageBytes;
    // Advice: where it is not taken, nothing is lost.
    ::madvise(reinterpret_cast<void*>(page), past - page, MADV_HUGEPAGE);
  }
#endif
  return array;
}

}  // namespace dn
