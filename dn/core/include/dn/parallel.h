#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <future>
#include <thread>
#include <utility>
#include <vector>

namespace dn {

/// Calls work(i) for i in [0, n), split into contiguous ranges over the threads. Rethrows the
/// exception of the lowest range that threw. If a thread cannot be started, the caller processes
/// its range.
template <class Work>
void ParallelFor(int n, int threads, const Work& work) {
  const int ranges = threads < n ? threads : n;
  if (ranges <= 1) {
    for (int i = 0; i < n; ++i) work(i);
    return;
  }
  std::vector<std::exception_ptr> errors(static_cast<std::size_t>(ranges));
  const auto do_range = [&](int k) {
    try {
      const auto begin = static_cast<int>(static_cast<long>(n) * k / ranges);
      const auto end = static_cast<int>(static_cast<long>(n) * (k + 1) / ranges);
      for (int i = begin; i < end; ++i) work(i);
    } catch (...) {
      errors[static_cast<std::size_t>(k)] = std::current_exception();
    }
  };
  std::vector<std::thread> pool;
  pool.reserve(static_cast<std::size_t>(ranges));
  int started = 0;
  try {
    for (; started < ranges; ++started) pool.emplace_back(do_range, started);
  } catch (const std::exception&) {
    for (int k = started; k < ranges; ++k) do_range(k);
  }
  for (std::thread& thread : pool) thread.join();
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

/// Starts work() in another thread if `threads` is above 1 and a thread is available; otherwise
/// work() runs when its result is requested. Returns the future of the result, whose destructor
/// waits for the work.
template <class Work>
auto Beside(int threads, Work work) {
  const std::launch how =
      threads > 1 ? std::launch::async | std::launch::deferred : std::launch::deferred;
  return std::async(how, std::move(work));
}

inline std::size_t NumChunks(std::size_t n, std::size_t size) { return (n + size - 1) / size; }

/// Calls work(chunk, first, past) for the chunks of `size` elements of [0, n); the last chunk may
/// be shorter. Sums per chunk do not depend on the number of threads.
template <class Work>
void ParallelForChunks(std::size_t n, std::size_t size, int threads, const Work& work) {
  ParallelFor(static_cast<int>(NumChunks(n, size)), threads, [&](int c) {
    const auto chunk = static_cast<std::size_t>(c);
    work(chunk, chunk * size, std::min(n, (chunk + 1) * size));
  });
}

}  // namespace dn
