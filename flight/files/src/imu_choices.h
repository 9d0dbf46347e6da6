#pragma once

#include <string>
#include <vector>

#include "picked_columns.h"
#include "text_sample.h"

namespace dn::files_internal {

/// A choice of the columns wx, wy, wz, fx, fy, fz.
struct ImuChoice {
  std::vector<NamedColumn> columns;
  double prior = 1.0;     ///< 1 for the usual order, less for others
  bool is_named = false;  ///< both vectors are named in the header
  bool is_usual = false;  ///< rates and forces follow the time directly
};

/// Returns the choices of rates and forces that a header names, sensor by sensor; none if it does
/// not name both.
std::vector<ImuChoice> NamedImuChoices(const TextSample& sample);

/// Returns every choice of three adjacent columns for rates and for forces after the time. Columns
/// that a header names as other quantities are left out. Angles are left out too, if their rates
/// are in the file. If the header names rates or forces, these are taken.
std::vector<ImuChoice> AllImuChoices(const TextSample& sample, const TimeColumn& time);

/// Says that a file has rates or accelerations but not both; empty for other files. A header with
/// only x, y, z has the sensor in the unit, in the name of the file, or in the size of gravity.
std::string SingleSensorReason(const TextSample& sample);

}  // namespace dn::files_internal
