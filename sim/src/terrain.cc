#include <dn/error.h>
#include <dn/sim/random.h>
#include <dn/sim/terrain.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kTallestObject_m = 22.0;  // above the highest ground
constexpr double kRayStep_m = 0.25;
constexpr int kWavesPerOctave = 4;
constexpr double kSmallestCell_m = 12.0;  // of buildings: they would touch
constexpr double kSmallestTreeCell_m = 4.0;

/// Numbers in [0, 1) that belong to one cell of a grid.
class CellNumbers {
 public:
  CellNumbers(std::uint64_t seed, const Eigen::Vector2i& cell) {
    const auto x = static_cast<std::uint32_t>(cell.x());
    const auto y = static_cast<std::uint32_t>(cell.y());
    state_ = MixBits(seed ^ MixBits((static_cast<std::uint64_t>(x) << 32) | y));
  }
  double Next() {
    state_ = MixBits(state_);
    return static_cast<double>(state_ >> 11) * 0x1.0p-53;
  }
  double Next(double low, double high) { return low + (high - low) * Next(); }

 private:
  std::uint64_t state_;
};

Eigen::Vector2i CellOf(const Vector2d& en_m, double cell_m) {
  return {static_cast<int>(std::floor(en_m.x() / cell_m)),
          static_cast<int>(std::floor(en_m.y() / cell_m))};
}

/// A rectangular house in its cell: flat, gabled or single-pitched roof.
struct Building {
  Vector2d centre_en_m;
  Vector2d axis;  // unit vector along the length
  double half_length_m;
  double half_width_m;
  double eaves_m;  // above the ground at the centre
  double slope;    // of the roof, 0: flat
  bool gabled;

  Building(CellNumbers numbers, const Eigen::Vector2i& cell, double cell_m) {
    const double room_m = 0.5 * cell_m - 0.5;  // radius of the circle that the house must fit in
    const double radius_m = std::min(room_m, numbers.Next(7.0, 16.0));
    const double aspect = numbers.Next(0.45, 1.0);
    half_length_m = radius_m / std::hypot(1.0, aspect);
    half_width_m = aspect * half_length_m;
    const double play_m = room_m - radius_m;
    const double dx = numbers.Next(-play_m, play_m), dy = numbers.Next(-play_m, play_m);
    centre_en_m = (cell.cast<double>() + Vector2d::Constant(0.5)) * cell_m + Vector2d(dx, dy);
    const double azimuth = numbers.Next(0.0, kPi);
    axis = {std::cos(azimuth), std::sin(azimuth)};
    eaves_m = numbers.Next(3.0, 12.0);
    const double roof = numbers.Next();
    gabled = roof >= 0.3 && roof < 0.85;
    slope = roof < 0.3 ? 0.0 : std::tan(numbers.Next(15.0, gabled ? 40.0 : 25.0) * kPi / 180.0);
  }

  /// Roof height above the ground at the centre; negative outside the house.
  double RoofAbove(const Vector2d& en_m) const {
    const Vector2d d = en_m - centre_en_m;
    const double along = d.dot(axis);
    const double across = axis.x() * d.y() - axis.y() * d.x();
    if (std::abs(along) > half_length_m || std::abs(across) > half_width_m) return -1.0;
    const double rise = gabled ? half_width_m - std::abs(across) : 0.5 * (half_width_m + across);
    return eaves_m + slope * rise;
  }
};

double CellSize(double per_km2, double smallest_m) {
  return per_km2 > 0.0 ? std::max(smallest_m, 1000.0 / std::sqrt(per_km2)) : 0.0;
}

}  // namespace

Terrain::Terrain(const TerrainScenario& scenario) : scenario_(scenario) {
  const TerrainKind kind = scenario_.kind;
  const bool flat = kind == TerrainKind::kFlat;
  const bool houses = kind == TerrainKind::kBuiltUp || kind == TerrainKind::kMixed;
  const std::uint64_t seed = scenario_.seed;
  if (houses) {
    buildings_ = {CellSize(scenario_.buildings_per_km2, kSmallestCell_m), MixBits(seed) ^ 1};
  }
  if (!flat) trees_ = {CellSize(scenario_.trees_per_km2, kSmallestTreeCell_m), MixBits(seed) ^ 2};

  if (!flat && scenario_.relief_m > 0.0) {
    Random random(seed, "terrain");
    const int octaves = kind == TerrainKind::kMountain ? 5 : 3;
    double sum = 0.0;
    for (int i = 0; i < octaves * kWavesPerOctave; ++i) {
      const int octave = i / kWavesPerOctave;
      const double wavelength_m = scenario_.wavelength_m * std::exp2(-(octave + random.Uniform()));
      const double azimuth = random.Uniform(0.0, 2.0 * kPi);
      const double amplitude = wavelength_m / scenario_.wavelength_m;
      waves_.push_back({2.0 * kPi / wavelength_m * Vector2d(std::cos(azimuth), std::sin(azimuth)),
                        random.Uniform(0.0, 2.0 * kPi), amplitude});
      sum += amplitude;
    }
    for (Wave& wave : waves_) wave.amplitude_m *= 0.5 * scenario_.relief_m / sum;
    relief_bound_m_ = 0.5 * scenario_.relief_m;
  }
  const bool objects = buildings_.cell_m > 0.0 || trees_.cell_m > 0.0;
  highest_m_ = scenario_.base_m + relief_bound_m_ + (objects ? kTallestObject_m : 0.0);
}

double Terrain::Ground(const Vector2d& en_m) const {
  double height_m = scenario_.base_m;
  for (const Wave& wave : waves_) {
    height_m += wave.amplitude_m * std::sin(wave.wavenumber.dot(en_m) + wave.phase_rad);
  }
  return height_m;
}

bool Terrain::BuiltUp(const Vector2d& en_m) const {
  if (scenario_.kind != TerrainKind::kMixed) return scenario_.kind == TerrainKind::kBuiltUp;
  const double k = 2.0 * kPi / 700.0;  // villages, and fields between them
  const double phase = static_cast<double>(scenario_.seed % 1000);
  return std::sin(k * en_m.x() + phase) + std::sin(k * en_m.y() + 2.0 * phase) > -0.3;
}

double Terrain::BuildingTop(const Vector2d& en_m) const {
  const Eigen::Vector2i cell = CellOf(en_m, buildings_.cell_m);
  const Building building(CellNumbers(buildings_.seed, cell), cell, buildings_.cell_m);
  const double above_m = building.RoofAbove(en_m);
  if (above_m < 0.0 || !BuiltUp(building.centre_en_m))
    return scenario_.base_m - 2.0 * relief_bound_m_;
  return Ground(building.centre_en_m) + above_m;
}

double Terrain::TreeTop(const Vector2d& en_m) const {
  const Eigen::Vector2i cell = CellOf(en_m, trees_.cell_m);
  CellNumbers numbers(trees_.seed, cell);
  const double radius_m = std::min(0.5 * trees_.cell_m, numbers.Next(1.5, 4.0));
  const double play_m = 0.5 * trees_.cell_m - radius_m;
  const double dx = numbers.Next(-play_m, play_m), dy = numbers.Next(-play_m, play_m);
  const Vector2d centre =
      (cell.cast<double>() + Vector2d::Constant(0.5)) * trees_.cell_m + Vector2d(dx, dy);
  const double height_m = numbers.Next(5.0, 18.0);
  const double x = (en_m - centre).squaredNorm() / (radius_m * radius_m);
  if (x > 1.0 || (scenario_.kind == TerrainKind::kMixed && BuiltUp(centre))) {
    return scenario_.base_m - 2.0 * relief_bound_m_;
  }
  return Ground(centre) + height_m * (1.0 - 0.6 * x);  // a crown that ends above the ground
}

double Terrain::Surface(const Vector2d& en_m) const {
  double height_m = Ground(en_m);
  if (buildings_.cell_m > 0.0) height_m = std::max(height_m, BuildingTop(en_m));
  if (trees_.cell_m > 0.0) height_m = std::max(height_m, TreeTop(en_m));
  return height_m;
}

std::optional<double> Terrain::Intersect(const Vector3d& origin_m, const Vector3d& direction,
                                         double max_range_m) const {
  if (!(direction.z() < 0.0)) throw InvalidInput("a laser ray must point downwards");
  const auto clearance_m = [&](double range_m) {
    const Vector3d point = origin_m + range_m * direction;
    return point.z() - Surface(point.head<2>());
  };
  double above_m = std::max(0.0, (highest_m_ - origin_m.z()) / direction.z());
  if (above_m >= max_range_m) return std::nullopt;
  if (clearance_m(above_m) <= 0.0) return above_m;
  while (above_m < max_range_m) {
    double below_m = std::min(above_m + kRayStep_m, max_range_m);
    if (clearance_m(below_m) > 0.0) {
      above_m = below_m;
      continue;
    }
    for (int i = 0; i < 40; ++i) {  // to 1e-12 of the step
      const double middle_m = 0.5 * (above_m + below_m);
      (clearance_m(middle_m) > 0.0 ? above_m : below_m) = middle_m;
    }
    return below_m;
  }
  return std::nullopt;
}

}  // namespace dn
