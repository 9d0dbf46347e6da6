#include <dn/error.h>
#include <dn/geo/little_endian.h>
#include <dn/geo/text_table.h>
#include <dn/rotation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "little_endian_records.h"
#include "trajectory_io.h"

namespace dn {
namespace geo_internal {
namespace {

constexpr std::size_t kSbetColumns = 17;
constexpr RecordFormat<kSbetColumns> kSbet{
    "SBET",
    {"time", "latitude", "longitude", "height", "velocity x", "velocity y", "velocity z", "roll",
     "pitch", "heading", "wander angle", "acceleration x", "acceleration y", "acceleration z",
     "rate x", "rate y", "rate z"}};

/// Largest difference from the positions at which the velocities of the file are accepted.
constexpr double kVelocityAgreementMps = 0.1;

using SbetRecord = Record<kSbetColumns>;

void CheckPositions(const std::vector<SbetRecord>& records, const FileLocation& where) {
  for (std::size_t i = 0; i < records.size(); ++i) {
    try {
      CheckGeodetic({records[i][1], records[i][2], records[i][3]});
    } catch (const InvalidInput& e) {
      throw InvalidInput(
          "SBET " + RecordName(i) + ": " + e.what() + "; SBET files contain radians, little endian",
          where);
    }
  }
}

bool HasLidarMark(const std::vector<SbetRecord>& records) {
  return std::all_of(records.begin(), records.end(),
                     [](const SbetRecord& c) { return c[10] == 0.0 && std::signbit(c[10]); });
}

NavPoint RecordPoint(const SbetRecord& c) {
  NavPoint point;
  point.t_s = c[0];
  point.position = {c[1], c[2], c[3]};
  const double true_heading_rad = c[9] - c[10];
  point.q_nb = QuaternionFromRollPitchHeading({c[7], c[8], true_heading_rad});
  point.f_b_mps2 = {c[11], c[12], c[13]};
  point.w_b_radps = {c[14], c[15], c[16]};
  return point;
}

/// Signs of the wander frame's y and z axes with respect to (right of x, down).
struct VelocityConvention {
  double y_sign;
  double z_sign;
  const char* text;
};

constexpr std::array<VelocityConvention, 4> kConventions{{{1, 1, "y right, z down"},
                                                          {1, -1, "y right, z up"},
                                                          {-1, 1, "y left, z down"},
                                                          {-1, -1, "y left, z up"}}};

Eigen::Vector3d VelocityNed(const SbetRecord& c, const VelocityConvention& convention) {
  const double cos_a = std::cos(c[10]), sin_a = std::sin(c[10]);
  const double vx = c[4], vy = convention.y_sign * c[5];
  // True azimuth = azimuth in the wander frame - wander angle.
  return {vx * cos_a + vy * sin_a, -vx * sin_a + vy * cos_a, convention.z_sign * c[6]};
}

/// Selects epochs to determine the convention; a fast recording is thinned out.
std::vector<std::size_t> SomeEpochs(const std::vector<NavPoint>& points) {
  constexpr double kSpacingS = 0.05;
  std::vector<std::size_t> some;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool last = i + 1 == points.size();
    if (last || some.empty() || points[i].t_s >= points[some.back()].t_s + kSpacingS) {
      some.push_back(i);
    }
  }
  return some;
}

/// Returns the difference in m/s between the positions and the velocities under each convention.
std::vector<double> MisfitsByConvention(const std::vector<SbetRecord>& records,
                                        const std::vector<NavPoint>& points) {
  std::vector<NavPoint> some_points;
  std::vector<std::vector<Eigen::Vector3d>> v_ned_mps(kConventions.size());
  for (const std::size_t i : SomeEpochs(points)) {
    some_points.push_back(points[i]);
    for (std::size_t k = 0; k < kConventions.size(); ++k) {
      v_ned_mps[k].push_back(VelocityNed(records[i], kConventions[k]));
    }
  }
  return VelocityMisfits(some_points, v_ned_mps);
}

/// Sets the points' velocities from the file or, if these disagree with the positions, by
/// differentiation.
void SettleVelocities(const std::vector<SbetRecord>& records, std::vector<NavPoint>& points,
                      TrajectoryNotes& notes) {
  const std::vector<double> misfits_mps = MisfitsByConvention(records, points);
  const auto best = static_cast<std::size_t>(
      std::min_element(misfits_mps.begin(), misfits_mps.end()) - misfits_mps.begin());
  notes.velocity_from_file = misfits_mps[best] <= kVelocityAgreementMps;
  const std::string misfit = FormatDouble(misfits_mps[best]) + " m/s";
  if (notes.velocity_from_file) {
    notes.text = std::string("velocities of the file, wander frame with ") +
                 kConventions[best].text + "; they differ from the positions by " + misfit;
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].v_ned_mps = VelocityNed(records[i], kConventions[best]);
    }
    return;
  }
  notes.text =
      "velocities from differentiated positions; the velocities of the file differ "
      "from them by " +
      misfit;
  const std::vector<Eigen::Vector3d> v_ned_mps = DifferentiatePositions(points);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].v_ned_mps = v_ned_mps[i];
}

/// Reads and checks the records of a file, and writes notes about them.
std::vector<SbetRecord> ReadRecords(const std::filesystem::path& file, TrajectoryNotes* notes) {
  const FileLocation where{file.string(), 0, 0};
  std::vector<SbetRecord> records = DecodeRecords(ReadWholeFile(file), kSbet, where);
  CheckPositions(records, where);
  notes->adjusted_with_lidar = HasLidarMark(records);
  notes->repeated_rows_dropped = MakeTimesContinuous(kSbet, where, &records);
  if (records.size() < 2) throw InvalidInput("SBET file has only one epoch, needs two", where);
  return records;
}

}  // namespace

Trajectory ReadSbet(const std::filesystem::path& file) {
  TrajectoryNotes notes;
  const std::vector<SbetRecord> records = ReadRecords(file, &notes);
  std::vector<NavPoint> points;
  points.reserve(records.size());
  for (const SbetRecord& record : records) points.push_back(RecordPoint(record));
  SettleVelocities(records, points, notes);
  return Trajectory(std::move(points), std::move(notes));
}

}  // namespace geo_internal

std::vector<NavPoint> ReadSbetThinned(const std::filesystem::path& file, double min_spacing_s) {
  TrajectoryNotes notes;
  std::vector<NavPoint> path;
  for (const geo_internal::SbetRecord& record : geo_internal::ReadRecords(file, &notes)) {
    if (!path.empty() && record[0] < path.back().t_s + min_spacing_s) continue;
    path.push_back(geo_internal::RecordPoint(record));
  }
  return path;
}

std::string FormatSbet(const std::vector<NavPoint>& points, bool adjusted_with_lidar) {
  std::string out;
  out.reserve(8 * geo_internal::kSbetColumns * points.size());
  for (const NavPoint& point : points) {
    const Eigen::Vector3d rph_rad = RollPitchHeading(point.q_nb);
    const double wander_rad = adjusted_with_lidar ? -0.0 : 0.0;
    const geo_internal::SbetRecord record{point.t_s,
                                          point.position.lat_rad,
                                          point.position.lon_rad,
                                          point.position.h_m,
                                          point.v_ned_mps.x(),
                                          point.v_ned_mps.y(),
                                          point.v_ned_mps.z(),
                                          rph_rad.x(),
                                          rph_rad.y(),
                                          rph_rad.z(),
                                          wander_rad,
                                          point.f_b_mps2.x(),
                                          point.f_b_mps2.y(),
                                          point.f_b_mps2.z(),
                                          point.w_b_radps.x(),
                                          point.w_b_radps.y(),
                                          point.w_b_radps.z()};
    for (const double value : record) AppendLittleEndian(value, out);
  }
  return out;
}

}  // namespace dn
