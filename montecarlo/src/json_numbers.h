#pragma once

#include <dn/report/json.h>

#include <Eigen/Core>
#include <limits>

namespace dn {

// JSON has no NaN: what cannot be told is null.
inline double NumberFromJson(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

inline Eigen::Vector3d Vector3FromJson(const Json& json) {
  return {NumberFromJson(json.at(0)), NumberFromJson(json.at(1)), NumberFromJson(json.at(2))};
}

}  // namespace dn
