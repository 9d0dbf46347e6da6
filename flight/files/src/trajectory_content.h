#pragma once

#include <dn/geo/text_table.h>
#include <dn/geo/trajectory_columns.h>

#include <optional>
#include <string>

namespace dn::internal {

/// The system of columns 2 to 4 of a text by their size and by speeds that are possible: "geographic",
/// "ecef", "utm:" (of any zone) or "map".
std::optional<std::string> CoordinatesOf(const TextTable& table);

/// What the columns of a text are, if they are a trajectory: 8 that end with a unit quaternion, or 7
/// that end with three angles of which the heading follows the course in most of the rows that move.
/// Coordinates are told by their size and by speeds that are possible; the zone of a grid cannot be:
/// "utm:". The convention of a quaternion is that by which the body moves forward, north-east-down
/// where nothing moves; its body is FLU where its z axis points up.
std::optional<TrajectoryColumns> TrajectoryColumnsOf(const TextTable& table);

}  // namespace dn::internal
