#include "strip_hints.h"

#include <dn/error.h>
#include <dn/geo/point_crs.h>
#include <dn/lidar/strip_io.h>

#include <vector>

namespace dn::apps {
namespace {

using Eigen::Vector3d;

// A level body along the course differs by this angle at most: crab, pitch and bank on a line.
constexpr double kLevelBodyRad = 0.35;
constexpr std::size_t kSampledPoints = 1000;

/// Returns some of the first points of a strip.
std::vector<StripSample> SampleStrip(StripReader* reader, const PointCrs& crs, double time_offset_s,
                                     bool with_vectors) {
  std::vector<StripSample> samples;
  StripCloud points;
  if (!reader->has_time() || !reader->Next(&points)) return samples;
  const bool vectors = with_vectors && reader->has_vectors();
  const std::size_t step = points.size() / kSampledPoints + 1;
  for (std::size_t i = 0; i < points.size(); i += step) {
    samples.push_back({points.t_s[i] - time_offset_s, crs.ToMap(points.p_c[i]),
                       vectors ? std::optional(points.u_s[i]) : std::nullopt});
  }
  return samples;
}

}  // namespace

std::optional<RoughPath> KnownPath(const Flight& flight) {
  if (flight.trajectory) {
    return RoughPath{flight.frame, flight.trajectory->ToMapPoses(flight.frame), false};
  }
  if (!flight.gnss) return std::nullopt;
  RoughPath path = PathFromGnss(*flight.gnss, flight.frame);
  if (path.poses.empty()) return std::nullopt;
  return path;
}

std::optional<StripDisagreement> CompareStrip(const std::filesystem::path& file,
                                              const FlightConfig& config, const RoughPath& path,
                                              bool with_vectors) {
  if (!config.lidar) return std::nullopt;
  try {
    const auto reader = OpenStrip(file);
    const std::vector<StripSample> samples =
        SampleStrip(reader.get(), PointCrs(config.strips_crs, path.frame),
                    config.lidar->time_offset_s, with_vectors);
    const Mounting& mounting = config.lidar->mounting;
    const double turn_rad =
        path.from_course ? kLevelBodyRad : LargestTurn(Vector3d::Zero(), mounting.boresight_rad);
    return FindStripDisagreement(
        samples, [&](double t_s) { return path.At(t_s); }, path.poses.front().t_s,
        path.poses.back().t_s, mounting, turn_rad);
  } catch (const InvalidInput&) {  // the commands that read all points report it
    return std::nullopt;
  }
}

}  // namespace dn::apps
