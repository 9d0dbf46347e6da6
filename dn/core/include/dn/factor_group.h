#pragma once

#include <string>
#include <vector>

namespace dn {

/// One residual of a factor in the words of the field.
struct RowName {
  std::string axis;           ///< "x", "east"
  std::string quantity = {};  ///< where a factor has several: "gyro", "velocity"

  friend bool operator==(const RowName&, const RowName&) = default;
};

/// Factors of one kind and what each of their residuals is: used by statistics, tests and reports.
///
///   FactorGroup{"altimeter", {{"up"}}}
///   FactorGroup{"inertial", {{"x", "gyro"}, {"y", "gyro"}, {"z", "gyro"}, {"x", "velocity"}, ..}}
struct FactorGroup {
  enum class Kind {
    kMeasurement,
    kProcess,  ///< how an unknown goes on with time
    kPrior,    ///< what is stated of an unknown beforehand
  };

  std::string name;                ///< "gnss position"; empty: none
  std::vector<RowName> rows = {};  ///< one per residual; empty: the axes are 0, 1, 2, ..
  std::string sensor = {};         ///< where several share the name: "gyro" of "gyro bias process"
  Kind kind = Kind::kMeasurement;

  /// Whether its residuals are those of a sensor or a process: named, and no prior.
  bool measured() const { return !name.empty() && kind != Kind::kPrior; }

  /// Sensor, name and quantity of a residual: "inertial gyro", "gyro bias process", "altimeter".
  /// Residuals of one channel have the same noise.
  std::string Channel(int row) const;
  /// "x"
  std::string Axis(int row) const;
  /// Quantity and axis, which tell the residuals of one factor apart: "gyro_x", "east".
  std::string QuantityAndAxis(int row) const;

  friend bool operator==(const FactorGroup&, const FactorGroup&) = default;
};

}  // namespace dn
