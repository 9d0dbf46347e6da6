#pragma once

#include <memory>

#include "cars.h"
#include "landform.h"
#include "plants.h"

namespace dn {

/// What a detailed terrain has in addition to relief, roughness and houses.
struct Scene {
  Plants plants;
  Streets streets;
  std::unique_ptr<const Landform> landform;  ///< null: none
};

}  // namespace dn
