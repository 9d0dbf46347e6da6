#include <fmt/format.h>

#include "calibrate_planes.h"

namespace dn::apps {

Json PlaneReportJson(const PlaneRun& planes) {
  const CorrelatedErrorCovariance& scatter = planes.calibration.scatter.trajectory;
  Json json = planes.extraction;
  json["within_flight_scatter"] = {
      {"sigma_deg", ToJson(scatter.covariance_rad2.diagonal().cwiseSqrt() * kDegPerRad)},
      {"attitude_ratio", scatter.attitude_ratio},
      {"position_ratio", scatter.position_ratio},
      {"evidence_nats", scatter.evidence_nats},
      {"nodes", scatter.nodes}};
  json["trajectory_sigma_source"] = planes.calibration.accuracy.source;
  return json;
}

void PrintPlanes(const PlaneRun& planes) {
  const PlaneAdjustment& adjustment = planes.calibration.adjustment;
  fmt::print("  {} of {} planes kept, {} points, {} left out\n", adjustment.planes_kept,
             planes.calibration.problem.planes.size(), adjustment.points_kept,
             adjustment.points_left_out);
  for (const auto& [pair, count] : adjustment.planes_by_strips) {
    fmt::print("    strips {}-{}: {}\n", planes.strips[static_cast<std::size_t>(pair.first)],
               planes.strips[static_cast<std::size_t>(pair.second)], count);
  }
  const Eigen::Vector3d& spread = adjustment.normals.eigenvalues;
  fmt::print("  spread of the normals {:.3f} {:.3f} {:.3f}\n", spread.x(), spread.y(), spread.z());
  fmt::print("  mean distance from the planes {:.3f} m before, {:.3f} m after\n",
             adjustment.residual_initial_m, adjustment.residual_final_m);
}

}  // namespace dn::apps
