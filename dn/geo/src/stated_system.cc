#include <utility>

#include "proj_objects.h"
#include "projected_crs.h"

namespace dn::geo_internal {
namespace {

std::optional<std::string> EpsgCode(const PJ* crs) {
  const char* authority = proj_get_id_auth_name(crs, 0);
  const char* code = proj_get_id_code(crs, 0);
  if (authority == nullptr || code == nullptr || std::string(authority) != "EPSG") {
    return std::nullopt;
  }
  return code;
}

/// Returns the code of a system, which it states or which PROJ finds with certainty.
std::optional<std::string> IdentifyPart(const PJ* crs) {
  if (auto code = EpsgCode(crs)) return code;
  int* confidence = nullptr;
  const ObjectList found(proj_identify(Context(), crs, "EPSG", nullptr, &confidence));
  constexpr int kCertain = 90;
  std::optional<std::string> code;
  if (found != nullptr && proj_list_get_count(found.get()) > 0 && confidence[0] >= kCertain) {
    code = EpsgCode(Object(proj_list_get(Context(), found.get(), 0)).get());
  }
  proj_int_list_destroy(confidence);
  return code;
}

/// Returns metres per unit of an axis.
double AxisUnitM(const PJ* crs, int axis) {
  const Object axes(proj_crs_get_coordinate_system(Context(), crs));
  double factor = 1.0;
  if (axes != nullptr) {
    proj_cs_get_axis_info(Context(), axes.get(), axis, nullptr, nullptr, nullptr, &factor, nullptr,
                          nullptr, nullptr);
  }
  return factor;
}

/// Returns whether a system has ellipsoidal heights as its third axis. Such a system has no code of
/// its own; that of its first two axes is the same in x and y.
bool HasHeightAxis(const PJ* crs) {
  const Object axes(proj_crs_get_coordinate_system(Context(), crs));
  return axes != nullptr && proj_cs_get_axis_count(Context(), axes.get()) == 3;
}

/// Returns well-known text in one line; empty if the system cannot be stated in this form.
std::string WellKnownText(const PJ* crs, PJ_WKT_TYPE form) {
  const char* const options[] = {"MULTILINE=NO", nullptr};
  const char* text = proj_as_wkt(Context(), crs, form, options);
  return text == nullptr ? "" : text;
}

}  // namespace

std::optional<StatedSystem> ReadSystem(const std::string& definition) {
  const Object crs = CreateCrs(definition);
  if (crs == nullptr) return std::nullopt;
  StatedSystem system;
  Object horizontal = HorizontalPart(crs.get());
  system.geocentric = proj_get_type(horizontal.get()) == PJ_TYPE_GEOCENTRIC_CRS;
  if (!system.geocentric && proj_get_type(horizontal.get()) != PJ_TYPE_PROJECTED_CRS) {
    return std::nullopt;
  }
  if (!system.geocentric && HasHeightAxis(horizontal.get())) {
    system.height_unit_m = AxisUnitM(horizontal.get(), 2);
    horizontal = Object(proj_crs_demote_to_2D(Context(), nullptr, horizontal.get()));
  }
  system.horizontal = IdentifyPart(horizontal.get());
  system.horizontal_text = WellKnownText(horizontal.get(), PJ_WKT2_2019);
  system.horizontal_unit_m = AxisUnitM(horizontal.get(), 0);
  system.compound = IsCompound(crs.get());
  if (!system.compound) return system;
  const Object vertical(proj_crs_get_sub_crs(Context(), crs.get(), 1));
  system.vertical = IdentifyPart(vertical.get());
  system.height_unit_m = AxisUnitM(vertical.get(), 0);
  return system;
}

std::optional<std::string> HorizontalEsriText(const std::string& definition) {
  const Object crs = CreateCrs(definition);
  if (crs == nullptr) return std::nullopt;
  const std::string text = WellKnownText(HorizontalPart(crs.get()).get(), PJ_WKT1_ESRI);
  return text.empty() ? std::nullopt : std::optional(text);
}

bool AreSameSystem(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const Object one = CreateCrs(a), other = CreateCrs(b);
  if (one == nullptr || other == nullptr) return false;
  return proj_is_equivalent_to(one.get(), other.get(),
                               PJ_COMP_EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS) != 0;
}

}  // namespace dn::geo_internal
