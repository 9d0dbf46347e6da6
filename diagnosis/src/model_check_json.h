#pragma once

#include <dn/diagnosis/model_check.h>
#include <dn/report/json.h>

namespace dn {

/// Returns `model_check` of result.json and smooth.json.
Json ModelCheckJson(const ModelCheck& check);

}  // namespace dn
