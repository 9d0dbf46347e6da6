#pragma once

#include <dn/blind_check/outsider.h>

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

namespace dn {

/// A described error with its numbers.
struct DrawnError {
  Eigen::Vector3d amplitude;  ///< in the unit of the quantity; a scalar is the first component
  std::function<double(double x)> shape;
  std::string of;        ///< argument of the shape
  double begin_s = 0.0;  ///< time at which the argument time_s is zero
};

/// Quantity to which a described error is added.
struct ErrorQuantity {
  const char* name;                ///< ends with its unit
  std::size_t axes;                ///< 1 or 3
  std::vector<std::string> known;  ///< possible arguments of a shape
  bool steps;                      ///< it may jump
  OwnErrors (*make)(const DrawnError& error, const Scenario& scenario);
};

const std::vector<ErrorQuantity>& ErrorQuantities();

/// Throws InvalidInput for an unknown name.
const ErrorQuantity& FindErrorQuantity(const std::string& name);

}  // namespace dn
