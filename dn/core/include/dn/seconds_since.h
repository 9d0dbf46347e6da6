#pragma once

#include <chrono>

namespace dn {

/// Returns the wall-clock time since `start`, s.
inline double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace dn
