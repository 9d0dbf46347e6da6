#pragma once

#include <memory>

#include "cars.h"
#include "landform.h"
#include "plants.h"

namespace dn {

/// Plants, cars and landforms of a detailed terrain, beside its relief, roughness and houses.
struct Scene {
  Plants plants;
  Streets streets;
  std::unique_ptr<const Landform> landform;  ///< null: none
};

}  // namespace dn
