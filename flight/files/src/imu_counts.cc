#include "imu_counts.h"

#include <dn/geo/local_frame.h>
#include <dn/geo/point_crs.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dn::files_internal {
namespace {

constexpr double kArcsecondRad = kRadPerDeg / 3600.0;
constexpr double kMilliG = 1e-3 * kStandardGravityMps2;
// The mean force of a vehicle differs from gravity by less, and half the distance of two sizes is
// more.
constexpr double kMostDifference = 0.1;

constexpr std::array<ImuCounts, 11> kImuCounts{
    {{"HG1700-AG11, HG1700-AG58, HG1900, HG1930", 0x1p-33, 0x1p-27 * kFootM},
     {"HG1700-AG17, HG1700-AG62", 0x1p-33, 0x1p-26 * kFootM},
     {"HG4930, CPT7", 0x1p-33, 0x1p-29},
     {"IMU-FSAS", 0.1 * 0x1p-8 * kArcsecondRad, 0.05 * 0x1p-15},
     {"LN200", 0x1p-19, 0x1p-14},
     {"ISA-100C", 1e-9, 2e-8},
     {"ADIS-16488, IGM-A1", 720.0 * 0x1p-31 * kRadPerDeg, 200.0 * 0x1p-31},
     {"STIM300, IGM-S1", 0x1p-21 * kRadPerDeg, 0x1p-22},
     {"EG320N at 125 Hz", 0.008 * 0x1p-16 / 125.0 * kRadPerDeg, 0.2 * 0x1p-16 * kMilliG / 125.0},
     {"EG320N at 200 Hz", 0.008 * 0x1p-16 / 200.0 * kRadPerDeg, 0.2 * 0x1p-16 * kMilliG / 200.0},
     {"EG370N", 0.0151515 * 0x1p-16 / 200.0 * kRadPerDeg, 0.4 * 0x1p-16 * kMilliG / 200.0}}};

}  // namespace

const ImuCounts* FindImuCounts(double mean_force) {
  const auto difference = [&](const ImuCounts& counts) {
    return std::abs(mean_force * counts.velocity_mps / kStandardGravityMps2 - 1.0);
  };
  const auto nearest = std::min_element(
      kImuCounts.begin(), kImuCounts.end(),
      [&](const ImuCounts& a, const ImuCounts& b) { return difference(a) < difference(b); });
  return difference(*nearest) < kMostDifference ? &*nearest : nullptr;
}

}  // namespace dn::files_internal
