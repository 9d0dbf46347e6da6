#include "proj_objects.h"

namespace dn::geo_internal {

PJ_CONTEXT* Context() {
  static thread_local const std::unique_ptr<PJ_CONTEXT, Destroy> context = [] {
    std::unique_ptr<PJ_CONTEXT, Destroy> made(proj_context_create());
    proj_context_set_enable_network(made.get(), 0);
    proj_log_level(made.get(), PJ_LOG_NONE);
    return made;
  }();
  return context.get();
}

Object CreateCrs(const std::string& definition) {
  Object crs(proj_create(Context(), definition.c_str()));
  if (crs != nullptr && proj_is_crs(crs.get()) == 0) crs.reset();
  return crs;
}

Object HorizontalPart(const PJ* crs) {
  if (proj_get_type(crs) == PJ_TYPE_COMPOUND_CRS) {
    return Object(proj_crs_get_sub_crs(Context(), crs, 0));
  }
  if (proj_get_type(crs) == PJ_TYPE_BOUND_CRS) {
    return Object(proj_get_source_crs(Context(), crs));
  }
  return Object(proj_clone(Context(), crs));
}

bool IsCompound(const PJ* crs) { return proj_get_type(crs) == PJ_TYPE_COMPOUND_CRS; }

}  // namespace dn::geo_internal
