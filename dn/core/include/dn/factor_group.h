#pragma once

#include <string>
#include <vector>

namespace dn {

/// Name of one residual of a factor in the field's terms.
struct RowName {
  std::string axis;           ///< for example "x", "east"
  std::string quantity = {};  ///< for a factor with several quantities: "gyro", "velocity"

  friend bool operator==(const RowName&, const RowName&) = default;
};

/// A kind of factors and the names of their residuals, for statistics, tests and reports.
///
///   FactorGroup{"altimeter", {{"up"}}}
///   FactorGroup{"inertial", {{"x", "gyro"}, {"y", "gyro"}, {"z", "gyro"}, {"x", "velocity"}, ..}}
struct FactorGroup {
  enum class Kind {
    kMeasurement,
    kProcess,  ///< evolution of an unknown in time
    kPrior,    ///< prior knowledge of an unknown
  };

  std::string name;                ///< for example "gnss position"; empty without a name
  std::vector<RowName> rows = {};  ///< one per residual; if empty, the axes are 0, 1, 2, ...
  std::string sensor = {};  ///< if several sensors share the name: "gyro" of "gyro bias process"
  Kind kind = Kind::kMeasurement;

  /// Returns true if the residuals belong to a sensor or a process: the group has a name and is not
  /// a prior.
  bool measured() const { return !name.empty() && kind != Kind::kPrior; }

  /// Returns sensor, name and quantity of a residual: "inertial gyro", "gyro bias process",
  /// "altimeter". Residuals of one channel have the same noise.
  std::string Channel(int row) const;
  /// Returns the axis of a residual, for example "x".
  std::string Axis(int row) const;
  /// Returns quantity and axis, which identify the residual within its factor: "gyro_x", "east".
  std::string QuantityAndAxis(int row) const;

  friend bool operator==(const FactorGroup&, const FactorGroup&) = default;
};

}  // namespace dn
