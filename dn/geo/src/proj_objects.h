#pragma once

#include <proj.h>
#include <proj_experimental.h>

#include <memory>
#include <string>

namespace dn::geo_internal {

struct Destroy {
  void operator()(PJ* object) const { proj_destroy(object); }
  void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
  void operator()(PJ_OPERATION_FACTORY_CONTEXT* context) const {
    proj_operation_factory_context_destroy(context);
  }
  void operator()(PJ_OBJ_LIST* list) const { proj_list_destroy(list); }
};
using Object = std::unique_ptr<PJ, Destroy>;
using ObjectList = std::unique_ptr<PJ_OBJ_LIST, Destroy>;

/// Returns the context of this thread, which reads no grids from the network.
PJ_CONTEXT* Context();

/// Returns the system of a code or of well-known text; null if PROJ does not know it.
Object CreateCrs(const std::string& definition);

bool IsCompound(const PJ* crs);

/// Returns the horizontal part of a system.
Object HorizontalPart(const PJ* crs);

}  // namespace dn::geo_internal
