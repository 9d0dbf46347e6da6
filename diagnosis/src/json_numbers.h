#pragma once

#include <dn/report/json.h>

#include <Eigen/Core>
#include <cmath>
#include <optional>

namespace dn::diagnosis_internal {

/// Converts a number; non-finite values become null.
inline Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

inline Json Scaled(const std::optional<double>& value, double factor) {
  return value ? Number(factor * *value) : Json();
}

inline Json Number(const std::optional<double>& value) { return Scaled(value, 1.0); }

template <class Values>
Json List(const Values& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(Number(value));
  return list;
}

inline Json Scaled(const std::optional<Eigen::Vector3d>& value, double factor) {
  return value ? List(Eigen::Vector3d(factor * *value)) : Json();
}

}  // namespace dn::diagnosis_internal
