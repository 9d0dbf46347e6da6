#include "cars.h"

#include <algorithm>
#include <cmath>

#include "terrain_objects.h"

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPlace_m = 6.5;  // length of a place for a car
constexpr double kLane_m = 2.2;   // distance of a car from the middle of the street
constexpr double kParked = 0.5;

/// Returns the range at which a ray enters the box.
std::optional<double> Enters(const Eigen::AlignedBox3d& box_m, const Vector3d& origin_m,
                             const Vector3d& direction, Stretch within) {
  const Vector3d from_m = origin_m - box_m.center(), half_m = 0.5 * box_m.sizes();
  for (int k = 0; k < 3; ++k) within = within.Within(from_m[k], direction[k], half_m[k]);
  return within.empty() ? std::nullopt : std::optional(within.from_m);
}

Eigen::AlignedBox3d Box(const Vector2d& middle_en_m, const Vector2d& half_m, double top_m) {
  Eigen::AlignedBox3d box;
  box.min() << middle_en_m - half_m, 0.0;
  box.max() << middle_en_m + half_m, top_m;
  return box;
}

Car MakeCar(CellNumbers* numbers, const Vector2d& middle_en_m, bool to_north) {
  const double length_m = numbers->Next(3.8, Streets::kLongestCar_m);
  const double width_m = numbers->Next(1.7, 1.9), top_m = numbers->Next(1.4, 1.8);
  Vector2d half_m(0.5 * length_m, 0.5 * width_m);
  Vector2d cabin_half_m(0.28 * length_m, 0.44 * width_m);
  if (to_north) {
    half_m = Vector2d(half_m.reverse());
    cabin_half_m = Vector2d(cabin_half_m.reverse());
  }
  return {Box(middle_en_m, half_m, 0.6 * top_m), Box(middle_en_m, cabin_half_m, top_m)};
}

}  // namespace

void Car::RaiseBy(double ground_m) {
  body_m.translate(ground_m * Vector3d::UnitZ());
  cabin_m.translate(ground_m * Vector3d::UnitZ());
}

std::optional<double> Car::FirstHit(const Vector3d& origin_m, const Vector3d& direction,
                                    const Stretch& within) const {
  const auto body = Enters(body_m, origin_m, direction, within);
  const auto cabin = Enters(cabin_m, origin_m, direction, within);
  return body && cabin ? std::min(body, cabin) : body ? body : cabin;
}

Streets::Streets(const TerrainScenario& scenario, double square_m)
    : square_m_(scenario.kind == TerrainKind::kTown ? square_m : 0.0),
      seed_(MixBits(scenario.seed) ^ 8) {
  if (square_m_ == 0.0) return;
  const double places_per_km2 =
      2.0 * std::floor(square_m_ / kPlace_m) * 1e6 / square_m_ / square_m_;
  occupied_ = std::min(1.0, scenario.cars_per_km2 / places_per_km2);
}

bool Streets::OnStreet(const Vector2d& en_m) const {
  if (square_m_ == 0.0) return false;
  const Vector2d place = en_m / square_m_;
  const Vector2d off = place - place.array().round().matrix();
  return off.cwiseAbs().minCoeff() * square_m_ < kHalfWidth_m;
}

std::vector<Car> Streets::CarsAt(const Eigen::Vector2i& square, std::uint64_t visit) const {
  std::vector<Car> cars;
  if (occupied_ == 0.0) return cars;
  const int places = static_cast<int>(square_m_ / kPlace_m);
  for (int k = 0; k < 2 * places; ++k) {
    CellNumbers place(seed_ + static_cast<std::uint64_t>(k), square);
    const bool parked = place.Next() < kParked;
    CellNumbers numbers(seed_ + static_cast<std::uint64_t>(k) + (parked ? 1000 : 2000 + visit),
                        square);
    if (numbers.Next() > occupied_) continue;
    const bool to_north = k < places;
    Vector2d offset_m(kLane_m, (k % places + 0.5) * kPlace_m);
    if (k % 2 == 0) offset_m.x() = -kLane_m;
    if (!to_north) offset_m = Vector2d(offset_m.reverse());
    cars.push_back(MakeCar(&numbers, square.cast<double>() * square_m_ + offset_m, to_north));
  }
  return cars;
}

}  // namespace dn
