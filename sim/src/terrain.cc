#include <dn/error.h>
#include <dn/sim/random.h>
#include <dn/sim/terrain.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scene.h"
#include "terrain_objects.h"

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kTallestObject_m = 22.0;  // above the relief at its centre
constexpr double kWidestObject_m = 16.0;   // from the centre of the object to its edge
constexpr double kSurelyClear_m = 1e-6;    // larger than the rounding error of a height
constexpr double kRayStep_m = 0.25;
constexpr int kWavesPerOctave = 4;
constexpr double kSmallestCell_m = 12.0;  // for buildings; in smaller cells they would touch
constexpr double kSmallestTreeCell_m = 4.0;
constexpr double kSmallestTownCell_m = 26.0;  // leaves room for streets
constexpr double kPitDepth_m = 1.0;           // no plants grow where the ground is lowered by more

/// Returns range_m after as many steps along a ray as stay below limit_m. Any number of steps is
/// exact up to the next power of two, where the resolution of a double changes. These steps are
/// taken at once.
double StepsBelow(double limit_m, double range_m) {
  while (range_m + kRayStep_m < limit_m) {
    const double exact_m = std::min(limit_m, std::exp2(std::ilogb(range_m) + 1));
    const double steps = std::floor((exact_m - range_m) / kRayStep_m) - 1.0;
    range_m += std::max(1.0, steps) * kRayStep_m;
  }
  return range_m;
}

double CellSize(double per_km2, double smallest_m) {
  return per_km2 > 0.0 ? std::max(smallest_m, 1000.0 / std::sqrt(per_km2)) : 0.0;
}

}  // namespace

Terrain::Terrain(const TerrainScenario& scenario)
    : scenario_(scenario), roughness_(scenario.roughness_m, scenario.seed) {
  const TerrainKind kind = scenario_.kind;
  const bool flat = kind == TerrainKind::kFlat;
  const bool town = kind == TerrainKind::kTown;
  const bool houses = town || kind == TerrainKind::kBuiltUp || kind == TerrainKind::kMixed;
  const std::uint64_t seed = scenario_.seed;
  if (houses) {
    const double smallest_m = town ? kSmallestTownCell_m : kSmallestCell_m;
    buildings_ = {CellSize(scenario_.buildings_per_km2, smallest_m), MixBits(seed) ^ 1};
    if (town) buildings_.margin_m = Streets::kHalfWidth_m;
  }
  if (HasScene(scenario_)) {
    scene_ = std::make_shared<const Scene>(Scene{Plants(scenario_),
                                                 Streets(scenario_, town ? buildings_.cell_m : 0.0),
                                                 MakeLandform(scenario_)});
  }
  if (!IsDetailed(kind) && !flat) {
    trees_ = {CellSize(scenario_.trees_per_km2, kSmallestTreeCell_m), MixBits(seed) ^ 2};
  }

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
    for (Wave& wave : waves_) {
      wave.amplitude_m *= 0.5 * scenario_.relief_m / sum;
      relief_slope_bound_ += wave.amplitude_m * wave.wavenumber.norm();
    }
    relief_bound_m_ = 0.5 * scenario_.relief_m;
  }
  const bool objects = buildings_.cell_m > 0.0 || trees_.cell_m > 0.0;
  highest_m_ = scenario_.base_m + relief_bound_m_ + roughness_.bound_m() +
               (objects ? kTallestObject_m : 0.0);
  above_relief_m_ = roughness_.bound_m() +
                    (objects ? kTallestObject_m + relief_slope_bound_ * kWidestObject_m : 0.0);
  highest_m_ += tallest_plant_m();
  if (scene_ && scene_->landform) {
    const double shape_m = scene_->landform->Everywhere().highest_m;
    highest_m_ += shape_m;
    above_relief_m_ += shape_m;
  }
  if (scenario_.water_share > 0.0) water_m_ = WaterLevel();
}

double Terrain::lowest_m() const {
  const double lowest_m = scenario_.base_m - relief_bound_m_ - roughness_.bound_m();
  const bool shaped = scene_ && scene_->landform;
  return shaped ? lowest_m + scene_->landform->Everywhere().lowest_m : lowest_m;
}

double Terrain::tallest_plant_m() const {
  return scene_ && !scene_->plants.empty() ? Plants::kTallest_m : 0.0;
}

double Terrain::ShapeSlope() const {
  return scene_ && scene_->landform ? scene_->landform->Everywhere().slope : 0.0;
}

double Terrain::DryGround(const Vector2d& en_m) const {
  const double height_m = Relief(en_m) + roughness_.At(en_m);
  return scene_ && scene_->landform ? height_m + scene_->landform->At(en_m) : height_m;
}

bool Terrain::SetOnGround(Plant* plant) const {
  const Vector2d en_m = plant->foot_m.head<2>();
  if (scene_->streets.OnStreet(en_m) || Water(en_m)) return false;
  if (scenario_.kind == TerrainKind::kMixed && BuiltUp(en_m)) return false;
  if (scene_->landform && scene_->landform->At(en_m) < -kPitDepth_m) return false;
  if (buildings_.cell_m > 0.0) {
    const auto building = BuildingIn(CellAt(en_m, buildings_.cell_m));
    if (building && building->Above(en_m) >= 0.0) return false;
  }
  plant->foot_m.z() = Ground(en_m);
  return true;
}

/// Returns the height below which the given fraction of the ground lies, estimated from samples.
double Terrain::WaterLevel() const {
  constexpr int kSamples = 100;  // in each direction
  constexpr double kSpacing = 0.137;
  std::vector<double> heights_m;
  for (int i = 0; i < kSamples; ++i) {
    for (int j = 0; j < kSamples; ++j) {
      const Vector2d place(i - kSamples / 2, j - kSamples / 2);
      heights_m.push_back(Relief(kSpacing * scenario_.wavelength_m * place));
    }
  }
  const double last = static_cast<double>(heights_m.size() - 1);
  const auto level = heights_m.begin() + std::lround(scenario_.water_share * last);
  std::nth_element(heights_m.begin(), level, heights_m.end());
  return *level;
}

double Terrain::Ground(const Vector2d& en_m) const {
  const double dry_m = DryGround(en_m);
  return water_m_ ? std::max(*water_m_, dry_m) : dry_m;
}

bool Terrain::Water(const Vector2d& en_m) const { return water_m_ && DryGround(en_m) < *water_m_; }

double Terrain::Relief(const Vector2d& en_m) const {
  double height_m = scenario_.base_m;
  for (const Wave& wave : waves_) {
    height_m += wave.amplitude_m * std::sin(wave.wavenumber.dot(en_m) + wave.phase_rad);
  }
  return height_m;
}

bool Terrain::BuiltUp(const Vector2d& en_m) const {
  if (scenario_.kind != TerrainKind::kMixed) return true;  // all other kinds with houses
  const double k = 2.0 * kPi / 700.0;                      // villages, and fields between them
  const double phase = static_cast<double>(scenario_.seed % 1000);
  return std::sin(k * en_m.x() + phase) + std::sin(k * en_m.y() + 2.0 * phase) > -0.3;
}

std::optional<Building> Terrain::BuildingIn(const Vector2i& cell) const {
  const Building building(CellNumbers(buildings_.seed, cell), cell, buildings_.cell_m,
                          buildings_.margin_m);
  if (!BuiltUp(building.centre_en_m) || Water(building.centre_en_m)) return std::nullopt;
  return building;
}

std::optional<Tree> Terrain::TreeIn(const Vector2i& cell) const {
  const Tree tree(CellNumbers(trees_.seed, cell), cell, trees_.cell_m);
  const bool village = scenario_.kind == TerrainKind::kMixed && BuiltUp(tree.centre_en_m);
  if (village || Water(tree.centre_en_m)) return std::nullopt;
  return tree;
}

/// Finds the objects at successive positions. An object found in a cell is reused for other
/// positions in that cell.
class Terrain::Objects {
 public:
  explicit Objects(const Terrain& terrain) : terrain_(terrain) {}

  /// Returns the height of the highest object at a position; -infinity without an object.
  double Top(const Vector2d& en_m) {
    const auto building_in = [this](const Vector2i& cell) { return terrain_.BuildingIn(cell); };
    const auto tree_in = [this](const Vector2i& cell) { return terrain_.TreeIn(cell); };
    return std::max(CellTop(en_m, terrain_.buildings_.cell_m, building_in, &building_),
                    CellTop(en_m, terrain_.trees_.cell_m, tree_in, &tree_));
  }

 private:
  static constexpr double kNone = -std::numeric_limits<double>::infinity();

  template <class Object>
  struct Occupied {
    std::optional<Vector2i> cell;
    std::optional<Object> object;
    double ground_m = 0.0;  // at the centre of the object
  };

  template <class Object, class Find>
  double CellTop(const Vector2d& en_m, double cell_m, const Find& find, Occupied<Object>* last) {
    if (cell_m <= 0.0) return kNone;
    const Vector2i cell = CellAt(en_m, cell_m);
    if (last->cell != cell) {
      last->cell = cell;
      last->object = find(cell);
      if (last->object) last->ground_m = terrain_.Relief(last->object->centre_en_m);
    }
    const double above_m = last->object ? last->object->Above(en_m) : -1.0;
    return above_m < 0.0 ? kNone : last->ground_m + above_m;
  }

  const Terrain& terrain_;
  Occupied<Building> building_;
  Occupied<Tree> tree_;
};

double Terrain::Surface(const Vector2d& en_m) const {
  return std::max(Ground(en_m), Objects(*this).Top(en_m));
}

Vector3d Gable::OnRoof(double back_m, double left_m) const {
  const Vector2d left(-outward.y(), outward.x());
  const Vector2d en_m = peak_m.head<2>() - back_m * outward + left_m * left;
  return {en_m.x(), en_m.y(), peak_m.z() - slope * std::abs(left_m)};
}

std::optional<Gable> Terrain::GableAt(const Vector2d& en_m, bool at_end) const {
  if (buildings_.cell_m <= 0.0) return std::nullopt;
  const std::optional<Building> house = BuildingIn(CellAt(en_m, buildings_.cell_m));
  if (!house || !house->gabled) return std::nullopt;
  Gable gable;
  gable.outward = at_end ? house->axis : Vector2d(-house->axis);
  gable.slope = house->slope;
  gable.half_width_m = house->half_width_m;
  gable.peak_m.head<2>() = house->centre_en_m + house->half_length_m * gable.outward;
  gable.peak_m.z() = Relief(house->centre_en_m) + house->RoofAcross(0.0);
  return gable;
}

/// The surface below a ray. Results for one range are reused for the next ranges.
class Terrain::AlongRay {
 public:
  AlongRay(const Terrain& terrain, const Vector3d& origin_m, const Vector3d& direction)
      : terrain_(terrain), origin_m_(origin_m), direction_(direction), objects_(terrain) {}

  /// Returns a range up to which the ray certainly meets nothing, from the maximum slope of the
  /// relief.
  double ClearUpTo(double range_m) const {
    const Vector3d point_m = At(range_m);
    double top_m = terrain_.Relief(point_m.head<2>()) + terrain_.above_relief_m_;
    if (terrain_.water_m_) top_m = std::max(top_m, *terrain_.water_m_);
    return range_m + (point_m.z() - top_m - kSurelyClear_m) / Nearing(terrain_.relief_slope_bound_);
  }

  /// Returns true if the ray is above the surface at this range.
  bool IsAbove(double range_m) {
    const Vector3d point_m = At(range_m);
    return IsAboveGround(range_m, point_m) && point_m.z() > objects_.Top(point_m.head<2>());
  }

 private:
  Vector3d At(double range_m) const { return origin_m_ + range_m * direction_; }

  /// Returns the maximum rate at which the ray approaches a surface of this slope, per unit of
  /// range.
  double Nearing(double slope) const {
    return -direction_.z() + slope * direction_.head<2>().norm();
  }

  bool IsAboveGround(double range_m, const Vector3d& point_m) {
    if (range_m >= above_from_m_ && range_m <= above_to_m_) return true;
    const double above_m = point_m.z() - terrain_.Ground(point_m.head<2>());
    above_from_m_ = range_m;
    above_to_m_ = range_m + (above_m - kSurelyClear_m) / Nearing(ground_slope_);
    return above_m > 0.0;
  }

  const Terrain& terrain_;
  const Vector3d origin_m_;
  const Vector3d direction_;
  const double ground_slope_ =
      terrain_.relief_slope_bound_ + terrain_.roughness_.slope_bound() + terrain_.ShapeSlope();
  double above_from_m_ = 0.0, above_to_m_ = -1.0;  // the ray meets no ground between these ranges
  Objects objects_;
};

std::optional<double> Terrain::Intersect(const Vector3d& origin_m, const Vector3d& direction,
                                         double max_range_m) const {
  if (!(direction.z() < 0.0)) throw InvalidInput("a laser ray must point downwards");
  AlongRay ray(*this, origin_m, direction);
  double above_m = std::max(0.0, (highest_m_ - origin_m.z()) / direction.z());
  if (above_m >= max_range_m) return std::nullopt;
  if (!ray.IsAbove(above_m)) return above_m;
  bool far = true;
  while (above_m < max_range_m) {
    if (far) {
      const double clear_m = std::min(ray.ClearUpTo(above_m), max_range_m);
      far = above_m + kRayStep_m < clear_m;
      above_m = StepsBelow(clear_m, above_m);
    }
    double below_m = std::min(above_m + kRayStep_m, max_range_m);
    if (ray.IsAbove(below_m)) {
      above_m = below_m;
      continue;
    }
    for (int i = 0; i < 40; ++i) {  // to 1e-12 of the step
      const double middle_m = 0.5 * (above_m + below_m);
      (ray.IsAbove(middle_m) ? above_m : below_m) = middle_m;
    }
    return below_m;
  }
  return std::nullopt;
}

}  // namespace dn
