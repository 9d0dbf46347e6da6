#include "large_array.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <new>

namespace dn {
namespace {

constexpr std::size_t kLargeBytes = std::size_t{4} << 20;
constexpr std::size_t kPageBytes = 4096;

/// Advice: where it is not taken, nothing is lost.
void AskForHugePages([[maybe_unused]] double* array, [[maybe_unused]] std::size_t size) {
#ifdef MADV_HUGEPAGE
  void* page = array;
  std::size_t bytes = size * sizeof(double);
  if (bytes >= kLargeBytes && std::align(kPageBytes, kPageBytes, page, bytes) != nullptr) {
    ::madvise(page, bytes / kPageBytes * kPageBytes, MADV_HUGEPAGE);
  }
#endif
}

}  // namespace

std::unique_ptr<double[]> NewArray(std::size_t size) {
  std::unique_ptr<double[]> array(new double[size]);
  AskForHugePages(array.get(), size);
  return array;
}

void FreeZeros::operator()(double* array) const noexcept { std::free(array); }

std::unique_ptr<double[], FreeZeros> NewZeros(std::size_t size) {
  std::unique_ptr<double[], FreeZeros> array(
      static_cast<double*>(std::calloc(std::max<std::size_t>(size, 1), sizeof(double))));
  if (array == nullptr) throw std::bad_alloc();
  AskForHugePages(array.get(), size);
  return array;
}

}  // namespace dn
