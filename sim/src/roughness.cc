#include <dn/sim/random.h>
#include <dn/sim/roughness.h>

#include <cmath>
#include <numbers>
#include <numeric>

namespace dn {
namespace {

constexpr double kCoarsest_m = 8.0;
constexpr double kHurst = 0.8;
// Mean square of one octave: (1/3) (integral of s^2 + (1 - s)^2)^2. The heights at the corners of a
// cell are uniform in [-1, 1]. The weight between them is s = 3 x^2 - 2 x^3.
constexpr double kMeanSquare = (1.0 / 3.0) * (26.0 / 35.0) * (26.0 / 35.0);
constexpr double kSteepestWeight = 1.5;  // largest slope of s

/// Returns the height of a lattice point, uniform in [-1, 1].
double Height(std::uint64_t seed, std::int64_t x, std::int64_t y) {
  const std::uint64_t key = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ull +
                            static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4full;
  return static_cast<double>(MixBits(seed ^ key) >> 11) * 0x1.0p-52 - 1.0;
}

double Weight(double x) { return x * x * (3.0 - 2.0 * x); }

double LatticeNoise(std::uint64_t seed, const Eigen::Vector2d& place) {
  const double west = std::floor(place.x()), south = std::floor(place.y());
  const auto x = static_cast<std::int64_t>(west), y = static_cast<std::int64_t>(south);
  const double east = Weight(place.x() - west), north = Weight(place.y() - south);
  const double lower = std::lerp(Height(seed, x, y), Height(seed, x + 1, y), east);
  const double upper = std::lerp(Height(seed, x, y + 1), Height(seed, x + 1, y + 1), east);
  return std::lerp(lower, upper, north);
}

double Cell(int octave) { return kCoarsest_m * std::exp2(-octave); }

}  // namespace

Roughness::Roughness(double rms_m, std::uint64_t seed) : seed_(MixBits(seed) ^ 3) {
  double variance = 0.0;
  for (int i = 0; i < kOctaves; ++i) {
    amplitude_m_[static_cast<std::size_t>(i)] = std::pow(Cell(i), kHurst);
    variance += kMeanSquare * std::pow(Cell(i), 2.0 * kHurst);
  }
  for (double& amplitude_m : amplitude_m_) amplitude_m *= rms_m / std::sqrt(variance);
}

double Roughness::At(const Eigen::Vector2d& en_m) const {
  if (amplitude_m_[0] == 0.0) return 0.0;
  double height_m = 0.0;
  Eigen::Vector2d place = en_m / kCoarsest_m;
  for (std::size_t i = 0; i < kOctaves; ++i, place *= 2.0) {
    height_m += amplitude_m_[i] * LatticeNoise(seed_ + i, place);
  }
  return height_m;
}

double Roughness::bound_m() const {
  return std::accumulate(amplitude_m_.begin(), amplitude_m_.end(), 0.0);
}

double Roughness::slope_bound() const {
  double slope = 0.0;  // the height changes by at most 2 over a cell, to the east and to the north
  for (int i = 0; i < kOctaves; ++i) {
    slope += amplitude_m_[static_cast<std::size_t>(i)] / Cell(i);
  }
  return 2.0 * kSteepestWeight * std::numbers::sqrt2 * slope;
}

}  // namespace dn
