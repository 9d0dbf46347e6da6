#include "projected_crs.h"

#include <dn/error.h>
#include <dn/names.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "proj_objects.h"

namespace dn::geo_internal {
namespace {

constexpr const char* kWgs84 = "EPSG:4979";  // latitude, longitude, ellipsoidal height
constexpr std::size_t kMostShown = 60;

/// The transformations that a thread has used.
std::map<std::string, Object>& ThisThread() {
  Context();  // outlives the transformations
  static thread_local std::map<std::string, Object> transformations;
  return transformations;
}

std::string Shown(const std::string& definition) {
  const std::string text = WithoutControls(definition);
  return text.size() <= kMostShown ? text : text.substr(0, kMostShown) + "...";
}

/// Returns the system with ellipsoidal heights if it has none.
Object WithHeight(Object crs) {
  if (IsCompound(crs.get())) return crs;
  Object promoted(proj_crs_promote_to_3D(Context(), nullptr, crs.get()));
  return promoted != nullptr ? std::move(promoted) : std::move(crs);
}

/// Returns true if the ellipsoid is that of WGS84 to a tenth of a millimetre. The datum of such a
/// system is geocentric and differs from WGS84 by less than 3 m.
bool HasModernEllipsoid(const PJ* crs) {
  const Object ellipsoid(proj_get_ellipsoid(Context(), crs));
  double a_m = 0.0, flattening = 0.0;
  return ellipsoid != nullptr &&
         proj_ellipsoid_get_parameters(Context(), ellipsoid.get(), &a_m, nullptr, nullptr,
                                       &flattening) != 0 &&
         a_m == 6378137.0 && std::abs(flattening - 298.25722) < 1e-4;
}

Object CreateTransformation(const PJ* crs, bool guess) {
  const Object wgs84 = CreateCrs(kWgs84);
  const std::string allow = std::string("ALLOW_BALLPARK=") + (guess ? "YES" : "NO");
  const std::array<const char*, 2> options{allow.c_str(), nullptr};
  Object plain(
      proj_create_crs_to_crs_from_pj(Context(), crs, wgs84.get(), nullptr, options.data()));
  if (plain == nullptr) return plain;
  return Object(proj_normalize_for_visualization(Context(), plain.get()));
}

/// Accuracies of the transformations that are possible now, and with all grids.
struct Alternatives {
  double available_m = HUGE_VAL;  ///< accuracy of the best one that is possible
  double missing_m = HUGE_VAL;    ///< accuracy of the best one that needs a missing grid
  std::string grid;               ///< that grid
};

std::string FindMissingGrid(const PJ* operation) {
  for (int g = 0; g < proj_coordoperation_get_grid_used_count(Context(), operation); ++g) {
    const char* name = nullptr;
    int available = 0;
    proj_coordoperation_get_grid_used(Context(), operation, g, &name, nullptr, nullptr, nullptr,
                                      nullptr, nullptr, &available);
    if (available == 0 && name != nullptr) return name;
  }
  return {};
}

/// Returns the transformations to WGS84 that are not guesses.
Alternatives FindAlternatives(const PJ* crs) {
  const std::unique_ptr<PJ_OPERATION_FACTORY_CONTEXT, Destroy> factory(
      proj_create_operation_factory_context(Context(), nullptr));
  proj_operation_factory_context_set_grid_availability_use(Context(), factory.get(),
                                                           PROJ_GRID_AVAILABILITY_IGNORED);
  proj_operation_factory_context_set_allow_ballpark_transformations(Context(), factory.get(), 0);
  const Object wgs84 = CreateCrs(kWgs84);
  const ObjectList all(proj_create_operations(Context(), crs, wgs84.get(), factory.get()));
  Alternatives found;
  for (int k = 0; all != nullptr && k < proj_list_get_count(all.get()); ++k) {
    const Object operation(proj_list_get(Context(), all.get(), k));
    const double accuracy_m = proj_coordoperation_get_accuracy(Context(), operation.get());
    const std::string grid = FindMissingGrid(operation.get());
    if (found.grid.empty()) found.grid = grid;
    if (accuracy_m < 0.0) continue;  // not known
    if (grid.empty()) {
      found.available_m = std::min(found.available_m, accuracy_m);
    } else if (accuracy_m < found.missing_m) {
      found.missing_m = accuracy_m;
      found.grid = grid;
    }
  }
  return found;
}

[[noreturn]] void FailTransformation(const std::string& definition, const std::string& grid) {
  throw InvalidConfig("the coordinate system " + Shown(definition) +
                      (grid.empty() ? " has no transformation to WGS84 that PROJ knows"
                                    : " needs the grid " + grid +
                                          ", which is not installed; put it into a folder and name "
                                          "the folder in PROJ_DATA"));
}

/// Returns the transformation to longitude and latitude (deg) and ellipsoidal height (m).
Object MakeTransformation(const std::string& definition) {
  Object crs = CreateCrs(definition);
  if (crs == nullptr) {
    throw InvalidConfig("'" + Shown(definition) +
                        "' is not a coordinate system that PROJ knows; use a code of the EPSG "
                        "register, such as epsg:25832");
  }
  const Object horizontal = HorizontalPart(crs.get());
  const PJ_TYPE type = proj_get_type(horizontal.get());
  if (type != PJ_TYPE_PROJECTED_CRS) {
    throw InvalidConfig("the coordinate system " + Shown(definition) +
                        " is not a projected one, with eastings and northings");
  }
  crs = WithHeight(std::move(crs));
  const bool modern = !IsCompound(crs.get()) && HasModernEllipsoid(horizontal.get());
  const Alternatives alternatives = modern ? Alternatives() : FindAlternatives(crs.get());
  if (alternatives.missing_m < alternatives.available_m) {
    FailTransformation(definition, alternatives.grid);
  }
  Object transformation = CreateTransformation(crs.get(), false);
  if (transformation == nullptr && modern) transformation = CreateTransformation(crs.get(), true);
  if (transformation == nullptr) FailTransformation(definition, alternatives.grid);
  return transformation;
}

PJ* Transformation(const std::string& definition) {
  std::map<std::string, Object>& known = ThisThread();
  auto at = known.find(definition);
  if (at == known.end()) at = known.emplace(definition, MakeTransformation(definition)).first;
  return at->second.get();
}

std::optional<Eigen::Vector3d> Transform(PJ* transformation, PJ_DIRECTION direction,
                                         const Eigen::Vector3d& p) {
  const PJ_COORD out =
      proj_trans(transformation, direction, proj_coord(p.x(), p.y(), p.z(), HUGE_VAL));
  const Eigen::Vector3d result(out.xyz.x, out.xyz.y, out.xyz.z);
  if (!result.allFinite()) {
    proj_errno_reset(transformation);
    return std::nullopt;
  }
  return result;
}

}  // namespace

ProjectedCrs::ProjectedCrs(std::string definition) : definition_(std::move(definition)) {
  Transformation(definition_);
}

std::optional<Geodetic> ProjectedCrs::ToGeodetic(const Eigen::Vector3d& p_c) const {
  const auto lon_lat_h = Transform(Transformation(definition_), PJ_FWD, p_c);
  if (!lon_lat_h) return std::nullopt;
  return Geodetic{lon_lat_h->y() * kRadPerDeg, lon_lat_h->x() * kRadPerDeg, lon_lat_h->z()};
}

std::optional<Eigen::Vector3d> ProjectedCrs::FromGeodetic(const Geodetic& point) const {
  return Transform(Transformation(definition_), PJ_INV,
                   {point.lon_rad * kDegPerRad, point.lat_rad * kDegPerRad, point.h_m});
}

}  // namespace dn::geo_internal
