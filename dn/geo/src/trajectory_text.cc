#include <dn/error.h>
#include <dn/geo/text_coordinates.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory.h>
#include <dn/rotation.h>

#include <cmath>
#include <string>

#include "trajectory_io.h"

namespace dn {
namespace geo_internal {
namespace {

using Attitude = TrajectoryColumns::Attitude;

/// A quaternion whose norm differs more from 1 is another quantity, not a rounded quaternion.
constexpr double kNormTolerance = 0.01;

/// Half a turn about the forward axis: FLU <-> FRD.
const Eigen::Quaterniond kFluFrd(0.0, 1.0, 0.0, 0.0);
/// Half a turn about north-east: ENU <-> NED.
const Eigen::Quaterniond kNedEnu(0.0, std::sqrt(0.5), std::sqrt(0.5), 0.0);

Eigen::Quaterniond ReadQuaternion(const double* wxyz, const FileLocation& where) {
  const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (q.norm() == 0.0) throw InvalidInput("attitude quaternion has zero norm", where);
  if (!(std::abs(q.norm() - 1.0) <= kNormTolerance)) {
    throw InvalidInput("attitude quaternion has norm " + FormatDouble(q.norm()) +
                           ", must be 1; columns are t, position (3), w, x, y, z: see "
                           "trajectory.crs and trajectory.attitude",
                       where);
  }
  return q.normalized();
}

void CheckAngles(const double* deg, const FileLocation& where) {
  if (std::abs(deg[0]) <= 180.0 && std::abs(deg[1]) <= 90.0 && std::abs(deg[2]) <= 360.0) return;
  throw InvalidInput("roll, pitch, heading are " + FormatDouble(deg[0]) + ", " +
                         FormatDouble(deg[1]) + ", " + FormatDouble(deg[2]) +
                         " deg, must be within 180, 90 and 360 deg",
                     where);
}

/// Returns the rotation from body (FRD) to the north-east-down frame of the file's attitude.
Eigen::Quaterniond ReadAttitude(const double* c, const TrajectoryColumns& columns,
                                const FileLocation& where) {
  if (columns.has_quaternion()) {
    Eigen::Quaterniond q = ReadQuaternion(c, where);
    if (columns.attitude == Attitude::kQuaternionEnu) q = kNedEnu * q;
    return columns.body_is_flu ? q * kFluFrd : q;
  }
  CheckAngles(c, where);
  const Eigen::Quaterniond q =
      QuaternionFromRollPitchHeading(kRadPerDeg * Eigen::Vector3d(c[0], c[1], c[2]));
  return columns.attitude == Attitude::kRollPitchHeading ? q : kNedEnu * q * kFluFrd;
}

}  // namespace

Trajectory ReadTrajectoryText(const std::filesystem::path& file, const TrajectoryColumns& columns) {
  const TextCoordinates positions(columns.crs, columns.map_origin, "trajectory.crs");
  const std::vector<std::string> quantities = TrajectoryQuantities(columns.has_quaternion());
  TextTable table = columns.names.empty() ? ReadTextTable(file, {1 + quantities.size()})
                                          : ReadNamedColumns(file, columns.names, quantities);
  std::vector<std::size_t> keep;
  TrajectoryNotes notes;
  notes.repeated_rows_dropped = ContinueAndCheckTimes(table, keep);
  notes.text = "velocities from differentiated positions";
  if (keep.size() < 2) {
    throw InvalidInput("trajectory has only one epoch, needs two", {file.string(), 0, 0});
  }
  std::vector<NavPoint> points;
  points.reserve(keep.size());
  for (const std::size_t i : keep) {
    const double* c = table.row(i);
    const FileLocation where{file.string(), table.lines[i], 0};
    NavPoint point;
    point.t_s = c[0];
    point.position = positions.Read(c + 1, where);
    point.q_nb = ReadAttitude(c + 4, columns, where);
    if (columns.grid_north) {
      const Eigen::Vector3d turn(0.0, 0.0, positions.Convergence_rad(point.position));
      point.q_nb = Exp(turn) * point.q_nb;
    }
    points.push_back(point);
  }
  const std::vector<Eigen::Vector3d> v_ned = DifferentiatePositions(points);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].v_ned_mps = v_ned[i];
  return Trajectory(std::move(points), std::move(notes));
}

}  // namespace geo_internal

std::vector<std::string> TrajectoryQuantities(bool quaternions) {
  if (quaternions) return {"lat", "lon", "h", "qw", "qx", "qy", "qz"};
  return {"lat", "lon", "h", "roll", "pitch", "heading"};
}

std::string FormatTrajectoryText(const std::vector<NavPoint>& points) {
  std::string out;
  for (const NavPoint& point : points) {
    const double row[] = {point.t_s,
                          point.position.lat_rad * kDegPerRad,
                          point.position.lon_rad * kDegPerRad,
                          point.position.h_m,
                          point.q_nb.w(),
                          point.q_nb.x(),
                          point.q_nb.y(),
                          point.q_nb.z()};
    const char* separator = "";
    for (const double value : row) {
      out += separator;
      out += FormatDouble(value);
      separator = ", ";
    }
    out += '\n';
  }
  return out;
}

}  // namespace dn
