#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

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

class ArrayPool;

struct BackToPool {
  ArrayPool* pool = nullptr;  ///< null: the array is freed
  std::size_t size = 0;
  void operator()(double* array) const noexcept;
};
using PooledArray = std::unique_ptr<double[], BackToPool>;

/// Arrays for work that needs large ones of slowly changing sizes, one after the other: one that is
/// done with serves the next, and the system need not clear its pages again. Of many threads at a
/// time. The arrays must not outlive it.
class ArrayPool {
 public:
  /// Keeps at most so many arrays that nobody uses.
  explicit ArrayPool(int most_kept);
  ~ArrayPool();
  ArrayPool(const ArrayPool&) = delete;
  ArrayPool& operator=(const ArrayPool&) = delete;

  /// Without numbers yet. Where none that is kept fits, all of them are freed first. Throws
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
  std::vector<Kept> kept_;  // empty ones hold nothing
};

}  // namespace dn
