#pragma once

#include <cmath>
#include <cstdio>

/// Prints a value with its bounds. Returns false if the value is outside them.
inline bool Between(const char* name, double value, double low, double high) {
  const bool inside = value >= low && value <= high;
  std::printf("%s %.6g, expected %.6g to %.6g%s\n", name, value, low, high,
              inside ? "" : ": FAILED");
  return inside;
}

/// Compares an estimate with the truth, in sigmas.
inline bool Agrees(const char* name, double estimate, double truth, double sigma) {
  constexpr double kSigmas = 4.0;
  return Between(name, (estimate - truth) / sigma, -kSigmas, kSigmas);
}
