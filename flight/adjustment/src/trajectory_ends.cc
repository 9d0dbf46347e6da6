#include <dn/adjustment/trajectory_ends.h>
#include <dn/error.h>

#include <algorithm>
#include <vector>

namespace dn {
namespace {

std::vector<MapPose> TrajectoryPoses(const Flight& flight) {
  if (!flight.trajectory || !flight.config.lidar || !flight.config.trajectory) {
    throw InvalidInput(
        "the flight needs a trajectory and the sections lidar and trajectory of flight.yaml");
  }
  return flight.trajectory->ToMapPoses(flight.frame);
}

}  // namespace

void InterpolationDeviation::Add(double angle_rad) {
  max_rad = std::max(max_rad, angle_rad);
  sum2_rad2 += angle_rad * angle_rad;
  n += 1.0;
}

void InterpolationDeviation::operator+=(const InterpolationDeviation& other) {
  max_rad = std::max(max_rad, other.max_rad);
  sum2_rad2 += other.sum2_rad2;
  n += other.n;
}

TrajectoryEnds::TrajectoryEnds(const Flight& flight)
    : flight_(flight), poses_(TrajectoryPoses(flight)) {}

GaussHelmertEnd TrajectoryEnds::At(double t_s, const Eigen::Vector3d& u_s,
                                   InterpolationDeviation* deviation) const {
  const bool linear_only = flight_.config.gh.libor_compat;
  MapPose pose = poses_.At(
      t_s, linear_only ? PoseInterpolator::Method::kLinear : PoseInterpolator::Method::kCubic);
  if (deviation != nullptr) {
    const MapPose other = poses_.At(
        t_s, linear_only ? PoseInterpolator::Method::kCubic : PoseInterpolator::Method::kLinear);
    deviation->Add(other.q_mb.angularDistance(pose.q_mb));
  }
  const TrajectoryConfig& trajectory = *flight_.config.trajectory;
  GaussHelmertEnd end;
  end.t_s = t_s;
  end.q_mb = pose.q_mb;
  end.p_mb = pose.p_mb;
  end.q_mn = Eigen::Quaterniond(flight_.frame.R_mn(pose.p_mb)).normalized();
  end.sigma_ned_m =
      Eigen::Vector3d(trajectory.sigma_xy_m, trajectory.sigma_xy_m, trajectory.sigma_z_m);
  end.sigma_rph_rad =
      Eigen::Vector3d(trajectory.sigma_rp_rad, trajectory.sigma_rp_rad, trajectory.sigma_y_rad);
  end.u_b = flight_.config.lidar->mounting.R_bs_nominal * u_s;
  return end;
}

}  // namespace dn
