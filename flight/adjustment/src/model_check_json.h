#pragma once

#include <dn/calibration/model_check.h>
#include <dn/report/json.h>

namespace dn {

/// `model_check` of result.json and smooth.json.
Json ModelCheckJson(const ModelCheck& check);

}  // namespace dn
