#pragma once

#include <dn/eigen_alignment.h>
#include <dn/report/json.h>

#include <Eigen/Core>
#include <limits>

namespace dn {

// These functions read null as NaN, because JSON cannot represent NaN.
inline double NumberFromJson(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

inline Eigen::Vector3d Vector3FromJson(const Json& json) {
  return {NumberFromJson(json.at(0)), NumberFromJson(json.at(1)), NumberFromJson(json.at(2))};
}

}  // namespace dn
