#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

#include "serial_blas.h"

namespace dn {

/// Calls work(i) for i in [0, n), each by the thread that is free first, the caller among them: for
/// pieces of unlike size. BLAS keeps to the thread that calls it. Rethrows the exception of the
/// first thread that threw, in their order; the others then start nothing more.
template <class Work>
void SideBySide(int n, int threads, const Work& work) {
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
  } catch (const std::system_error&) {  // the threads that there are do it
  }
  take(&errors.back());
  for (std::thread& thread : pool) thread.join();
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

/// Columns, or rows, of a dense matrix that are worked on at once.
inline constexpr int kPanel = 192;

/// Calls work(first, n) for the panels of [0, size), side by side.
template <class Work>
void ForPanels(int size, int threads, const Work& work) {
  SideBySide((size + kPanel - 1) / kPanel, threads,
             [&](int p) { work(p * kPanel, std::min(kPanel, size - p * kPanel)); });
}

}  // namespace dn
