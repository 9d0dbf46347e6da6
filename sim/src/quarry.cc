#include <algorithm>
#include <cmath>
#include <numbers>

#include "landform.h"
#include "terrain_objects.h"

namespace dn {
namespace {

using Eigen::Vector2d;

// One pit in each square.
constexpr double kSquare_m = 400.0;
constexpr double kRadius_m = 140.0;  // mean radius of the rim
constexpr double kWiggle = 0.12;     // relative change of the radius with azimuth
constexpr int kLobes = 3;
constexpr double kMargin_m = 15.0;  // distance between a pit and the border of its square
// Benches follow the rim.
constexpr int kBenches = 3;
constexpr double kBench_m = 20.0;  // width, with the face
constexpr double kFace_m = 4.0;    // width of the face
constexpr double kFaceHeight_m = 8.0;
// Heaps are cones with the angle of repose of gravel.
constexpr double kHeapSquare_m = 14.0;
constexpr double kRepose = 0.7;  // tan(35 deg)
constexpr double kHeaps = 0.4;   // share of the squares that have a heap
constexpr double kFade_m = 6.0;
// The distance to the rim changes by at most this much per metre. It is largest at the lowest face,
// which is nearest to the middle of the pit.
constexpr double kLowestFace_m = kRadius_m * (1.0 - kWiggle) - kBenches * kBench_m;
constexpr double kTurning = kLobes * kWiggle * kRadius_m / kLowestFace_m;
const double kRimSlope = std::hypot(1.0, kTurning);

/// Returns the depth below the rim at a distance inside it.
double DepthBelowRim(double inside_m) {
  const double bench = std::clamp(inside_m / kBench_m, 0.0, static_cast<double>(kBenches));
  const double whole = std::min(std::floor(bench), kBenches - 1.0);
  return kFaceHeight_m * (whole + std::min(1.0, (bench - whole) * kBench_m / kFace_m));
}

class Quarry final : public Landform {
 public:
  explicit Quarry(std::uint64_t seed) : seed_(seed) {}

  double At(const Vector2d& en_m) const override {
    const double inside_m = Inside(en_m);
    if (inside_m <= 0.0) return 0.0;
    const double floor = std::clamp((inside_m - kBenches * kBench_m) / kFade_m, 0.0, 1.0);
    return floor * Heap(en_m) - DepthBelowRim(inside_m);
  }

  Bounds Everywhere() const override {
    return {-kBenches * kFaceHeight_m, 0.0, kFaceHeight_m / kFace_m * kRimSlope};
  }

  Bounds Near(const Vector2d& en_m, double radius_m) const override {
    return Inside(en_m) + kRimSlope * radius_m < 0.0 ? Bounds{} : Everywhere();
  }

 private:
  /// Returns the distance to the rim of the pit, positive inside.
  double Inside(const Vector2d& en_m) const {
    const Eigen::Vector2i cell = CellAt(en_m, kSquare_m);
    CellNumbers numbers(seed_, cell);
    const double play_m = 0.5 * kSquare_m - (1.0 + kWiggle) * kRadius_m - kMargin_m;
    const double east_m = numbers.Next(-play_m, play_m), north_m = numbers.Next(-play_m, play_m);
    const double phase = numbers.Next(0.0, 2.0 * std::numbers::pi);
    const Vector2d middle_m = (cell.cast<double>() + Vector2d::Constant(0.5)) * kSquare_m;
    const Vector2d from_m = en_m - middle_m - Vector2d(east_m, north_m);
    const double lobes = std::cos(kLobes * std::atan2(from_m.y(), from_m.x()) + phase);
    return kRadius_m * (1.0 + kWiggle * lobes) - from_m.norm();
  }

  double Heap(const Vector2d& en_m) const {
    const Eigen::Vector2i cell = CellAt(en_m, kHeapSquare_m);
    CellNumbers numbers(~seed_, cell);
    if (numbers.Next() > kHeaps) return 0.0;
    const double radius_m = numbers.Next(2.0, 0.5 * kHeapSquare_m);
    const Vector2d middle_m = (cell.cast<double>() + Vector2d::Constant(0.5)) * kHeapSquare_m;
    return kRepose * std::max(0.0, radius_m - (en_m - middle_m).norm());
  }

  std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<const Landform> MakeQuarry(std::uint64_t seed) {
  return std::make_unique<Quarry>(seed);
}

}  // namespace dn
