#include <algorithm>
#include <cmath>
#include <numbers>

#include "landform.h"
#include "terrain_objects.h"

namespace dn {
namespace {

using Eigen::Vector2d;

constexpr double kFieldLength_m = 160.0, kFieldWidth_m = 90.0;
constexpr double kPath_m = 1.5;  // half the width of the path around a field
constexpr double kHighestRow_m = 0.15;
constexpr double kNarrowestRow_m = 0.75;

class CropRows final : public Landform {
 public:
  explicit CropRows(std::uint64_t seed) : seed_(seed) {}

  double At(const Vector2d& en_m) const override {
    const Vector2d place(en_m.x() / kFieldLength_m, en_m.y() / kFieldWidth_m);
    const Eigen::Vector2i cell = CellAt(place, 1.0);
    CellNumbers numbers(seed_, cell);
    const double height_m = std::max(0.0, numbers.Next(-0.05, kHighestRow_m));
    const double spacing_m = numbers.Next(1.0, 2.0) * kNarrowestRow_m;
    const double azimuth = numbers.Next(0.0, std::numbers::pi);
    const double across_m = std::cos(azimuth) * en_m.x() + std::sin(azimuth) * en_m.y();
    const double wave = 1.0 + std::sin(2.0 * std::numbers::pi * across_m / spacing_m);
    return 0.5 * height_m * Inside(place - cell.cast<double>()) * wave;
  }

  Bounds Everywhere() const override {
    return {0.0, kHighestRow_m,
            kHighestRow_m * (std::numbers::pi / kNarrowestRow_m + 1.0 / kPath_m)};
  }
  Bounds Near(const Vector2d&, double) const override { return Everywhere(); }

 private:
  /// Returns 0 on the path and 1 inside the field. The place is in units of the field.
  static double Inside(const Vector2d& place) {
    const double east_m = std::min(place.x(), 1.0 - place.x()) * kFieldLength_m;
    const double north_m = std::min(place.y(), 1.0 - place.y()) * kFieldWidth_m;
    return std::clamp(std::min(east_m, north_m) / kPath_m - 1.0, 0.0, 1.0);
  }

  std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<const Landform> MakeCropRows(std::uint64_t seed) {
  return std::make_unique<CropRows>(seed);
}

std::unique_ptr<const Landform> MakeLandform(const TerrainScenario& scenario) {
  const std::uint64_t seed = MixBits(scenario.seed) ^ 7;
  if (scenario.kind == TerrainKind::kFields) return MakeCropRows(seed);
  return scenario.kind == TerrainKind::kQuarry ? MakeQuarry(seed) : nullptr;
}

}  // namespace dn
