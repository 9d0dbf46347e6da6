#pragma once

#include <nlohmann/json_fwd.hpp>

namespace dn {

/// JSON value whose objects keep the order in which their keys are written. Headers that only name
/// the type include this file: dn/report/json.h takes half a second to compile.
using Json = nlohmann::ordered_json;

}  // namespace dn
