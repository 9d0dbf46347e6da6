#include <dn/calibration/result.h>
#include <dn/imu/strapdown.h>

#include <algorithm>

namespace dn {
namespace {

constexpr double kSameTime_s = 1e-6;

// One leg from node i to node i + 1: poses at the sample epochs, corrected so that the leg closes.
void AppendLeg(const FlightNetwork& network, const CalibrationState& calibration, std::size_t i,
               double min_spacing_s, std::vector<MapPose>* out,
               std::vector<ImuCorrection>* corrections) {
  const Flight& flight = network.flight();
  const MapPose start = network.NodePose(i);
  const MapPose end = network.NodePose(i + 1);
  const ImuCorrection correction =
      calibration.ImuAt(network.GyroBias(start.t_s), network.AccelBias(start.t_s));
  const Eigen::Vector3d attraction_mps2 = calibration.AttractionAt(start.p_mb);
  out->push_back(start);
  corrections->push_back(correction);
  const std::size_t first = out->size();
  MapPose pose = start;
  const auto [begin, past] = SampleRange(*flight.imu, start.t_s, end.t_s);
  const auto step_to = [&](double t_s) {
    pose = Propagate(flight.frame, pose, Preintegrate(*flight.imu, pose.t_s, t_s, correction, {}),
                     attraction_mps2);
  };
  for (std::size_t k = begin; k < past; ++k) {
    const double t_s = flight.imu->samples[k].t_s;
    if (t_s - pose.t_s < min_spacing_s - kSameTime_s) continue;
    if (end.t_s - t_s < std::max(kSameTime_s, 0.5 * min_spacing_s)) continue;
    step_to(t_s);
    out->push_back(pose);
    corrections->push_back(correction);
  }
  step_to(end.t_s);
  const Eigen::Vector3d dphi = Log(Eigen::Quaterniond(pose.q_mb.conjugate() * end.q_mb));
  const Eigen::Vector3d dp = end.p_mb - pose.p_mb;
  const Eigen::Vector3d dv = end.v_m - pose.v_m;
  for (std::size_t k = first; k < out->size(); ++k) {
    MapPose& inner = (*out)[k];
    const double share = (inner.t_s - start.t_s) / (end.t_s - start.t_s);
    inner.q_mb = inner.q_mb * Exp(Eigen::Vector3d(share * dphi));
    inner.p_mb += share * dp;
    inner.v_m += share * dv;
  }
}

}  // namespace

std::vector<NavPoint> DenseTrajectory(const FlightNetwork& network, double min_spacing_s) {
  std::vector<MapPose> poses;
  std::vector<ImuCorrection> corrections;
  const CalibrationState calibration = network.Calibration();
  std::size_t edge = 0;
  const auto& edges = network.inertial_edges;
  for (std::size_t i = 0; i < network.nodes.size(); ++i) {
    if (edge < edges.size() && edges[edge].node_i == i) {
      AppendLeg(network, calibration, i, min_spacing_s, &poses, &corrections);
      ++edge;
    } else {
      poses.push_back(network.NodePose(i));
      const double t_s = poses.back().t_s;
      corrections.push_back(calibration.ImuAt(network.GyroBias(t_s), network.AccelBias(t_s)));
    }
  }
  const Flight& flight = network.flight();
  std::vector<NavPoint> points;
  points.reserve(poses.size());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    NavPoint point = ToNavPoint(poses[k], flight.frame);
    const Preintegrated here = IdentityIncrement(*flight.imu, point.t_s, corrections[k]);
    point.w_b_radps = here.w_end_b_radps;
    point.f_b_mps2 = here.f_end_b_mps2;
    points.push_back(point);
  }
  return points;
}

}  // namespace dn
