#pragma once

#include <dn/report/json.h>

#include <Eigen/Core>
#include <limits>
#include <vector>

namespace dn::apps {

// JSON has no NaN: what cannot be told is null.
inline double Number(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

inline std::vector<double> Numbers(const Json& json) {
  std::vector<double> numbers;
  for (const Json& number : json) numbers.push_back(Number(number));
  return numbers;
}

inline Eigen::Vector3d Vector3FromJson(const Json& json) {
  return {Number(json.at(0)), Number(json.at(1)), Number(json.at(2))};
}

}  // namespace dn::apps
