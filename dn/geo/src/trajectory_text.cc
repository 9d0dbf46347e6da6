#include <dn/error.h>
#include <dn/geo/text_table.h>

#include <cmath>

#include "trajectory_io.h"

namespace dn {
namespace internal {
namespace {

/// A quaternion further from unit norm than this is another quantity, not a rounded quaternion.
constexpr double kNormTolerance = 0.01;

const Eigen::Quaterniond& q_flu_frd() {
  static const Eigen::Quaterniond q(0.0, 1.0, 0.0, 0.0);  // half a turn about the forward axis
  return q;
}

Eigen::Quaterniond ReadQuaternion(const double* wxyz, const FileLocation& where) {
  const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (q.norm() == 0.0) throw InvalidInput("attitude quaternion has zero norm", where);
  if (!(std::abs(q.norm() - 1.0) <= kNormTolerance)) {
    throw InvalidInput("attitude quaternion has norm " + FormatDouble(q.norm()) +
                           ", must be 1; columns are t, lat, lon [deg], h, w, x, y, z",
                       where);
  }
  return q.normalized();
}

}  // namespace

Trajectory ReadTrajectoryText(const std::filesystem::path& file, bool body_is_flu) {
  TextTable table = ReadTextTable(file, {8});
  std::vector<std::size_t> keep;
  TrajectoryNotes notes;
  notes.repeated_rows_dropped = ContinueAndCheckTimes(table, keep);
  notes.text = "velocities by differentiation of the positions";
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
    point.position = {c[1] * kRadPerDeg, c[2] * kRadPerDeg, c[3]};
    CheckGeodetic(point.position, where);
    point.q_nb = ReadQuaternion(c + 4, where);
    if (body_is_flu) point.q_nb = point.q_nb * q_flu_frd();
    points.push_back(point);
  }
  const std::vector<Eigen::Vector3d> v_ned = DifferentiatedVelocities(points);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].v_ned_mps = v_ned[i];
  return Trajectory(std::move(points), std::move(notes));
}

}  // namespace internal

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
