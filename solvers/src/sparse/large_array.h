#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace dn::sparse {

/// Returns an uninitialised array. For a large array it asks the operating system for huge pages,
/// so that one page fault replaces 512.
std::unique_ptr<double[]> NewArray(std::size_t size);

struct FreeZeros {
  void operator()(double* array) const noexcept;
};

/// Returns an array of zeros. Pages that the operating system hands out already cleared are not
/// written again. Throws std::bad_alloc.
std::unique_ptr<double[], FreeZeros> NewZeros(std::size_t size);

class ArrayPool;

struct BackToPool {
  ArrayPool* pool = nullptr;  ///< null: the array is freed
  std::size_t size = 0;
  void operator()(double* array) const noexcept;
};
using PooledArray = std::unique_ptr<double[], BackToPool>;

/// A pool of large work arrays with slowly changing sizes. A released array is used for the next
/// request, so the system need not clear its pages again. Several threads may use the pool at the
/// same time. The arrays must not outlive it.
class ArrayPool {
 public:
  /// Keeps at most `most_kept` released arrays.
  explicit ArrayPool(int most_kept);
  ~ArrayPool();
  ArrayPool(const ArrayPool&) = delete;
  ArrayPool& operator=(const ArrayPool&) = delete;

  /// Returns an uninitialised array. If no kept array fits, all kept arrays are freed first. Throws
  /// std::bad_alloc.
  PooledArray New(std::size_t size);

 private:
  friend BackToPool;
  struct Kept {
    std::unique_ptr<double[]> array;
    std::size_t size = 0;
  };
  void Keep(Kept returned) noexcept;
  std::unique_ptr<double[]> Take(std::size_t* size);

  std::mutex mutex_;
  std::vector<Kept> kept_;  // unused entries are empty
};

}  // namespace dn::sparse
