#pragma once

#include <dn/blind_check/outsider.h>

#include <functional>
#include <string>
#include <vector>

namespace dn {

/// Shape of a described error: a function of one argument whose largest value is near 1. A drawn
/// shape is a JSON object.
struct Shape {
  const char* name;
  const char* parameter;  ///< key of its range in the file; empty if it has none
  bool needs_time;        ///< the argument must be the time
  Json (*draw)(double lowest, double highest, const FlightTimes& times, Random& random);
  std::function<double(double x)> (*make)(const Json& drawn);
};

const std::vector<Shape>& Shapes();

/// Throws InvalidInput for an unknown name.
const Shape& FindShape(const std::string& name);

}  // namespace dn
