#include "sparse/large_array.h"

#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <memory>
#include <new>
#include <utility>

namespace dn::sparse {
namespace {

constexpr std::size_t kLargeBytes = std::size_t{4} << 20;
constexpr std::size_t kPageBytes = 4096;

/// Asks the system for huge pages; the array also works without them.
void AskForHugePages([[maybe_unused]] double* array, [[maybe_unused]] std::size_t size) {
#ifdef MADV_HUGEPAGE
  void* page = array;
  std::size_t bytes = size * sizeof(double);
  if (bytes >= kLargeBytes && std::align(kPageBytes, kPageBytes, page, bytes) != nullptr) {
    ::madvise(page, bytes / kPageBytes * kPageBytes, MADV_HUGEPAGE);
  }
#endif
}

/// Rounds up to the next of a set of sizes that are 1/7 to 1/4 apart, so that a slightly larger
/// request also fits.
std::size_t Rounded(std::size_t size) {
  const std::size_t step = std::bit_floor(size) / 4;
  return (size + step - 1) / step * step;
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

void BackToPool::operator()(double* array) const noexcept {
  std::unique_ptr<double[]> returned(array);
  if (pool != nullptr) pool->Keep({std::move(returned), size});
}

ArrayPool::ArrayPool(int most_kept) : kept_(static_cast<std::size_t>(most_kept)) {}

ArrayPool::~ArrayPool() = default;

PooledArray ArrayPool::New(std::size_t size) {
  if (size * sizeof(double) < kLargeBytes) return PooledArray(new double[size]);
  size = Rounded(size);
  std::unique_ptr<double[]> array = Take(&size);
  if (array == nullptr) array = NewArray(size);
  return {array.release(), BackToPool{this, size}};
}

/// Takes the smallest kept array with at least `size` and at most twice as many numbers, and sets
/// `size` to its size.
std::unique_ptr<double[]> ArrayPool::Take(std::size_t* size) {
  const std::lock_guard lock(mutex_);
  Kept* best = nullptr;
  for (Kept& kept : kept_) {
    const bool fits = kept.size >= *size && kept.size <= 2 * *size;
    if (fits && (best == nullptr || kept.size < best->size)) best = &kept;
  }
  if (best != nullptr) {
    *size = std::exchange(best->size, 0);
    return std::move(best->array);
  }
  for (Kept& kept : kept_) kept = {};
  return nullptr;
}

/// Replaces the smallest kept array if the returned one is larger.
void ArrayPool::Keep(Kept returned) noexcept {
  const std::lock_guard lock(mutex_);
  const auto smallest = std::min_element(
      kept_.begin(), kept_.end(), [](const Kept& a, const Kept& b) { return a.size < b.size; });
  if (smallest != kept_.end() && smallest->size < returned.size) std::swap(*smallest, returned);
}

}  // namespace dn::sparse
