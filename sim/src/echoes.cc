#include "echoes.h"

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

constexpr double kPulseLength_m = 0.6;  // half of 4 ns
constexpr double kWeakest = 0.015;
constexpr double kMeanSquareSlope = 0.02;

double Reflectance(Surface surface) {
  switch (surface) {
    case Surface::kGround:
      return 0.3;
    case Surface::kBuilding:
      return 0.35;
    case Surface::kCar:
      return 0.25;
    case Surface::kLowPlant:
    case Surface::kHighPlant:
      return 0.4;
    case Surface::kWater:
      return 1.0;
  }
  return 0.0;
}

/// Adds an echo to a return.
void Merge(const Echo& echo, Echo* into) {
  const double energy = into->energy + echo.energy;
  if (energy <= 0.0) return;
  if (echo.energy > into->energy) into->surface = echo.surface;
  into->range_m += echo.energy / energy * (echo.range_m - into->range_m);
  into->energy = energy;
}

}  // namespace

double EchoEnergy(const RayHit& hit, double part) {
  const double cosine = std::clamp(hit.cosine, 0.0, 1.0);
  if (hit.surface != Surface::kWater) return part * Reflectance(hit.surface) * cosine;
  const double tan2 = 1.0 / std::max(1e-6, cosine * cosine) - 1.0;
  return part * std::exp(-tan2 / kMeanSquareSlope);
}

unsigned char PointClass(Surface surface) {
  switch (surface) {
    case Surface::kGround:
      return 2;
    case Surface::kLowPlant:
      return 3;
    case Surface::kHighPlant:
      return 5;
    case Surface::kBuilding:
      return 6;
    case Surface::kWater:
      return 9;
    case Surface::kCar:
      return 1;
  }
  return 0;
}

Echoes Detected(Echoes echoes, double resolution_m, int max_returns) {
  const auto begin = echoes.list.begin(), end = begin + static_cast<std::ptrdiff_t>(echoes.count);
  std::sort(begin, end, [](const Echo& a, const Echo& b) { return a.range_m < b.range_m; });
  Echoes detected;
  for (auto first = begin; first != end;) {
    Echo merged = *first;
    const double start_m = first->range_m;
    auto next = std::next(first);
    for (; next != end && next->range_m < start_m + kPulseLength_m; ++next) Merge(*next, &merged);
    first = next;
    if (merged.energy < kWeakest) continue;
    if (detected.count < static_cast<std::size_t>(max_returns)) detected.Add(merged);
    while (first != end && first->range_m < start_m + resolution_m) ++first;
  }
  return detected;
}

}  // namespace dn
