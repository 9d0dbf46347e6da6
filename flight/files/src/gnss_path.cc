#include "gnss_path.h"

#include <dn/geo/local_frame.h>
#include <dn/median.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "plausible_motion.h"

namespace dn::files_internal {
namespace {

constexpr double kMostPathHeightM = 2e4;

/// Returns the distance between two places in degrees of latitude. The longitude may jump by 360
/// deg, and near a pole its differences are short.
double StepDeg(const double* a, const double* b) {
  const double lon = std::remainder(b[2] - a[2], 360.0);
  return std::hypot(b[1] - a[1], lon * std::cos(b[1] / kDegPerRad));
}

/// Returns whether at least half of the values have more than three decimals. A receiver writes
/// degrees with many decimals, and qualities, counts and dilutions with few.
bool HaveDecimals(const TextTable& table, std::size_t at) {
  constexpr double kThousand = 1e3, kRounding = 1e-5;
  std::size_t count = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double value = kThousand * table.row(i)[at];
    if (std::abs(value - std::round(value)) > kRounding) ++count;
  }
  return 2 * count >= table.rows();
}

double MedianSpeedMps(const TextTable& table) {
  std::vector<double> speeds_mps;
  for (std::size_t i = 1; i < table.rows(); ++i) {
    const double step_s = table.row(i)[0] - table.row(i - 1)[0];
    if (step_s > 0.0) {
      speeds_mps.push_back(kMetresPerDeg * StepDeg(table.row(i - 1), table.row(i)) / step_s);
    }
  }
  return speeds_mps.empty() ? 0.0 : Median(speeds_mps);
}

}  // namespace

bool AreCoordinates(const TextTable& table) {
  const double limit_deg = 0.01 + 60.0 * kMostSpeedMps / kMetresPerDeg;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double* row = table.row(i);
    if (std::abs(row[1]) > 360.0 || std::abs(row[2]) > 360.0) return false;
    if (std::abs(row[3]) > kMostPathHeightM) return false;
    if (i > 0 && StepDeg(table.row(i - 1), row) > limit_deg) return false;
  }
  return true;
}

bool IsLongitudeFirst(const TextTable& table) {
  bool beyond = false;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (std::abs(table.row(i)[2]) > 90.0) return false;
    beyond = beyond || std::abs(table.row(i)[1]) > 90.0;
  }
  return beyond;
}

bool AreCertainCoordinates(const TextTable& table) {
  return AreCoordinates(table) && HaveDecimals(table, 1) && HaveDecimals(table, 2) &&
         MedianSpeedMps(table) < kMostSpeedMps;
}

bool AreIntegers(const TextTable& table, std::size_t at) {
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (table.row(i)[at] != std::floor(table.row(i)[at])) return false;
  }
  return true;
}

bool IsMoving(const TextTable& table) {
  for (std::size_t i = 1; i < table.rows(); ++i) {
    if (StepDeg(table.row(0), table.row(i)) > 0.0) return true;
  }
  return false;
}

double LargestValue(const TextTable& table, std::size_t at) {
  double largest = 0.0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    largest = std::max(largest, std::abs(table.row(i)[at]));
  }
  return largest;
}

}  // namespace dn::files_internal
