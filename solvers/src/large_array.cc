#include "large_array.h"

#include <sys/mman.h>

#include <memory>

namespace dn {
namespace {

constexpr std::size_t kLargeBytes = std::size_t{4} << 20;
constexpr std::size_t kPageBytes = 4096;

}  // namespace

std::unique_ptr<double[]> NewArray(std::size_t size) {
  std::unique_ptr<double[]> array(new double[size]);
#ifdef MADV_HUGEPAGE
  void* page = array.get();
  std::size_t bytes = size * sizeof(double);
  if (bytes >= kLargeBytes && std::align(kPageBytes, kPageBytes, page, bytes) != nullptr) {
    // Advice: where it is not taken, nothing is lost.
    ::madvise(page, bytes / kPageBytes * kPageBytes, MADV_HUGEPAGE);
  }
#endif
  return array;
}

}  // namespace dn
