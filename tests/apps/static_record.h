#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>

namespace dn::testing {

constexpr double kRate_hz = 50.0;
constexpr double kArw_deg_sqrt_h = 0.3, kVrw_m_s_sqrt_h = 0.06;

/// Returns the record of a sensor at rest with white noise. A gap and a rotation can be added.
inline std::string StaticRecord(int seconds, int gap_from = -1, double turn_radps = 0.0) {
  std::mt19937 rng(7);
  std::normal_distribution<double> normal;
  const double w = kArw_deg_sqrt_h * std::numbers::pi / 180.0 / 60.0 * std::sqrt(kRate_hz);
  const double f = kVrw_m_s_sqrt_h / 60.0 * std::sqrt(kRate_hz);
  std::string text;
  char row[200];
  const int rows = seconds * static_cast<int>(kRate_hz);
  for (int k = 0; k < rows; ++k) {
    const double turn = k > rows / 2 ? turn_radps : 0.0;
    std::array<double, 6> x{};
    for (double& value : x) value = normal(rng);
    if (k >= gap_from && gap_from >= 0 && k < gap_from + 100) continue;
    std::snprintf(row, sizeof row, "%.3f,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n",
                  1000.0 + (k + 1) / kRate_hz, w * x[0], w * x[1], w * x[2] + turn, f * x[3],
                  f * x[4], f * x[5] - 9.81);
    text += row;
  }
  return text;
}

}  // namespace dn::testing
