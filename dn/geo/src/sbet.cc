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
namespace internal {
namespace {

constexpr std::size_t kSbetColumns = 17;
constexpr RecordFormat<kSbetColumns> kSbet{
    "SBET",
    {"time", "latitude", "longitude", "height", "velocity x", "velocity y", "velocity z", "roll",
     "pitch", "heading", "wander angle", "acceleration x", "acceleration y", "acceleration z",
     "rate x", "rate y", "rate z"}};

/// The file's velocities count as confirmed by its positions up to this difference.
constexpr double kVelocityAgreementMps = 0.1;

using SbetRecord = Record<kSbetColumns>;

void CheckPositions(const std::vector<SbetRecord>& records, const FileLocation& where) {
  for (std::size_t i = 0; i < records.size(); ++i) {
    try {
      CheckGeodetic({records[i][1], records[i][2], records[i][3]});
    } catch (const InvalidInput& e) {
      throw InvalidInput(
          "SBET " + NameOfRecord(i) + ": " + e.what() + "; SBET holds radians, little endian",
          where);
    }
  }
}

bool HasLidarMark(const std::vector<SbetRecord>& records) {
  return std::all_of(records.begin(), records.end(),
                     [](const SbetRecord& c) { return c[10] == 0.0 && std::signbit(c[10]); });
}

NavPoint PointOfRecord(const SbetRecord& c) {
  NavPoint point;
  point.t_s = c[0];
  point.position = {c[1], c[2], c[3]};
  const double true_heading_rad = c[9] - c[10];
  point.q_nb = QuaternionFromRollPitchHeading({c[7], c[8], true_heading_rad});
  point.f_b_mps2 = {c[11], c[12], c[13]};
  point.w_b_radps = {c[14], c[15], c[16]};
  return point;
}

/// Signs of the wander frame's y and z axis with respect to (right of x, down).
struct VelocityConvention {
  double y_sign;
  double z_sign;
  const char* text;
};

constexpr std::array<VelocityConvention, 4> kConventions{{{1, 1, "y right, z down"},
                                                          {1, -1, "y right, z up"},
                                                          {-1, 1, "y left, z down"},
                                                          {-1, -1, "y left, z up"}}};

std::vector<Eigen::Vector3d> VelocitiesNed(const std::vector<SbetRecord>& records,
                                           const VelocityConvention& convention) {
  std::vector<Eigen::Vector3d> v_ned;
  v_ned.reserve(records.size());
  for (const SbetRecord& c : records) {
    const double cos_a = std::cos(c[10]), sin_a = std::sin(c[10]);
    const double vx = c[4], vy = convention.y_sign * c[5];
    // True azimuth = azimuth in the wander frame - wander angle.
    v_ned.emplace_back(vx * cos_a + vy * sin_a, -vx * sin_a + vy * cos_a, convention.z_sign * c[6]);
  }
  return v_ned;
}

/// Fills the points' velocities from the file or, failing that, from the positions.
void SettleVelocities(const std::vector<SbetRecord>& records, std::vector<NavPoint>& points,
                      TrajectoryNotes& notes) {
  std::vector<std::vector<Eigen::Vector3d>> v_ned;
  for (const VelocityConvention& convention : kConventions) {
    v_ned.push_back(VelocitiesNed(records, convention));
  }
  const std::vector<double> misfits_mps = VelocityMisfits(points, v_ned);
  const auto best = static_cast<std::size_t>(
      std::min_element(misfits_mps.begin(), misfits_mps.end()) - misfits_mps.begin());
  const double best_misfit_mps = misfits_mps[best];
  std::vector<Eigen::Vector3d> best_v_ned = std::move(v_ned[best]);
  notes.velocity_from_file = best_misfit_mps <= kVelocityAgreementMps;
  const std::string misfit = FormatDouble(best_misfit_mps) + " m/s";
  if (notes.velocity_from_file) {
    notes.text = std::string("velocities of the file, wander frame with ") +
                 kConventions[best].text + "; they differ from the positions by " + misfit;
  } else {
    best_v_ned = DifferentiatedVelocities(points);
    notes.text =
        "velocities by differentiation of the positions, from which those of the file "
        "differ by " +
        misfit;
  }
  for (std::size_t i = 0; i < points.size(); ++i) points[i].v_ned_mps = best_v_ned[i];
}

}  // namespace

Trajectory ReadSbet(const std::filesystem::path& file) {
  const FileLocation where{file.string(), 0, 0};
  std::vector<SbetRecord> records = DecodeRecords(ReadWholeFile(file), kSbet, where);
  CheckPositions(records, where);
  TrajectoryNotes notes;
  notes.adjusted_with_lidar = HasLidarMark(records);
  notes.repeated_rows_dropped = SettleTimes(kSbet, where, &records);
  if (records.size() < 2) throw InvalidInput("SBET file has only one epoch, needs two", where);
  std::vector<NavPoint> points;
  points.reserve(records.size());
  for (const SbetRecord& record : records) points.push_back(PointOfRecord(record));
  SettleVelocities(records, points, notes);
  return Trajectory(std::move(points), std::move(notes));
}

}  // namespace internal

std::vector<NavPoint> ReadSbetPath(const std::filesystem::path& file, double min_spacing_s) {
  const FileLocation where{file.string(), 0, 0};
  std::vector<internal::SbetRecord> records =
      internal::DecodeRecords(ReadWholeFile(file), internal::kSbet, where);
  internal::SettleTimes(internal::kSbet, where, &records);
  std::vector<NavPoint> path;
  for (const internal::SbetRecord& record : records) {
    if (!path.empty() && record[0] < path.back().t_s + min_spacing_s) continue;
    path.push_back(internal::PointOfRecord(record));
  }
  return path;
}

std::string FormatSbet(const std::vector<NavPoint>& points, bool adjusted_with_lidar) {
  std::string out;
  out.reserve(8 * internal::kSbetColumns * points.size());
  for (const NavPoint& point : points) {
    const Eigen::Vector3d rph_rad = RollPitchHeading(point.q_nb);
    const double wander_rad = adjusted_with_lidar ? -0.0 : 0.0;
    const internal::SbetRecord record{point.t_s,
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
