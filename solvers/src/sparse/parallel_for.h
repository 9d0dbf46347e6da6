#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

#include "sparse/serial_blas.h"

namespace dn::sparse {

/// Calls work(i) for i in [0, n) on several threads including the caller; each idle thread takes
/// the next i. This suits items of unequal cost. BLAS uses one thread inside `work`. If threads
/// throw, the exception of the first of them (in thread order) is rethrown, and no further items
/// are started.
template <class Work>
void ParallelForDynamic(int n, int threads, const Work& work) {
  const int helpers = std::min(threads, n) - 1;
  if (helpers < 1) {
    for (int i = 0; i < n; ++i) work(i);
    return;
  }
  std::atomic<int> next{0};
  std::vector<std::exception_ptr> errors(static_cast<std::size_t>(helpers) + 1);
  const auto take = [&](std::exception_ptr* error) {
    try {
      const SerialBlas serial;
      for (int i = next++; i < n; i = next++) work(i);
    } catch (...) {
      *error = std::current_exception();
      next = n;
    }
  };
  std::vector<std::thread> pool;
  try {
    for (int k = 0; k < helpers; ++k) pool.emplace_back(take, &errors[static_cast<std::size_t>(k)]);
  } catch (const std::system_error&) {  // the threads created so far do all the work
  }
  take(&errors.back());
  for (std::thread& thread : pool) thread.join();
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

/// Number of columns, or rows, of a dense matrix that are processed together.
inline constexpr int kPanelSize = 192;

/// Calls work(first, n) in parallel for the panels of [0, size).
template <class Work>
void ForPanels(int size, int threads, const Work& work) {
  ParallelForDynamic((size + kPanelSize - 1) / kPanelSize, threads, [&](int p) {
    work(p * kPanelSize, std::min(kPanelSize, size - p * kPanelSize));
  });
}

}  // namespace dn::sparse
