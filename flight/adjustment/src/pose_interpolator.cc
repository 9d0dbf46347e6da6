#include <dn/adjustment/pose_interpolator.h>
#include <dn/error.h>
#include <dn/rotation.h>

#include <algorithm>
#include <array>

namespace dn {
namespace {

constexpr double kFarSteps = 3.0;  // a neighbour further away is not used

}  // namespace

PoseInterpolator::PoseInterpolator(std::vector<MapPose> poses) : poses_(std::move(poses)) {
  if (poses_.size() < 2) throw InvalidInput("a trajectory needs at least two epochs");
}

Eigen::Quaterniond PoseInterpolator::AttitudeAt(std::size_t k, double t_s) const {
  const double far_s = kFarSteps * (poses_[k + 1].t_s - poses_[k].t_s);
  std::array<std::size_t, 4> used{};
  std::size_t n = 0;
  if (k > 0 && poses_[k].t_s - poses_[k - 1].t_s <= far_s) used[n++] = k - 1;
  used[n++] = k;
  used[n++] = k + 1;
  if (k + 2 < poses_.size() && poses_[k + 2].t_s - poses_[k + 1].t_s <= far_s) used[n++] = k + 2;

  const Eigen::Quaterniond& q_k = poses_[k].q_mb;
  Eigen::Vector3d phi = Eigen::Vector3d::Zero();
  for (std::size_t m = 0; m < n; ++m) {
    const MapPose& pose = poses_[used[m]];
    double weight = 1.0;
    for (std::size_t o = 0; o < n; ++o) {
      if (o == m) continue;
      weight *= (t_s - poses_[used[o]].t_s) / (pose.t_s - poses_[used[o]].t_s);
    }
    phi += weight * Log(Eigen::Quaterniond(q_k.conjugate() * pose.q_mb));
  }
  return (q_k * Exp(phi)).normalized();
}

MapPose PoseInterpolator::Nearest(double t_s) const {
  return At(std::clamp(t_s, poses_.front().t_s, poses_.back().t_s));
}

MapPose PoseInterpolator::At(double t_s, Method method) const {
  MapPose pose = InterpolatePose(poses_, t_s);
  const auto after = std::upper_bound(poses_.begin(), poses_.end(), t_s,
                                      [](double t, const MapPose& next) { return t < next.t_s; });
  if (after == poses_.end()) return pose;  // the last epoch itself
  const auto k = static_cast<std::size_t>(after - poses_.begin()) - 1;
  if (method == Method::kCubic) {
    pose.q_mb = AttitudeAt(k, t_s);
  } else {
    const double s = (t_s - poses_[k].t_s) / (poses_[k + 1].t_s - poses_[k].t_s);
    pose.p_mb = (1.0 - s) * poses_[k].p_mb + s * poses_[k + 1].p_mb;
  }
  return pose;
}

}  // namespace dn
