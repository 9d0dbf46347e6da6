#pragma once

#include <dn/geo/text_table.h>
#include <dn/geo/trajectory_columns.h>

#include <optional>
#include <string>

namespace dn::files_internal {

/// Returns the coordinate system of columns 2 to 4 of a text: "geographic", "ecef", "utm:" (any
/// zone) or "map". It follows from the size of the values and from plausible speeds. Returns
/// nullopt if no system fits.
std::optional<std::string> FindCoordinateSystem(const TextTable& table);

/// Returns the columns of a text if it is a trajectory. It must have 8 columns that end with a unit
/// quaternion, or 7 that end with three angles. The heading must follow the course in most of the
/// moving rows. The coordinate system is that of FindCoordinateSystem; the zone of a grid cannot be
/// determined ("utm:"). The convention of a quaternion is the one for which the body moves forward,
/// or north-east-down without motion. The body is FLU if its z axis points up.
std::optional<TrajectoryColumns> FindTrajectoryColumns(const TextTable& table);

/// Returns the share of the moving rows whose heading is near the course. It is that of the better
/// convention of the columns of FindTrajectoryColumns, for an upright body. Returns nullopt if too
/// few rows move.
std::optional<double> CourseAgreement(const TextTable& table);

/// Least course agreement of an attitude.
inline constexpr double kLeastCourseAgreement = 0.7;

}  // namespace dn::files_internal
