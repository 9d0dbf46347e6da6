#include <dn/error.h>
#include <dn/imu/implied_imu.h>
#include <dn/imu/strapdown.h>
#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace dn {
namespace {

/// Returns one sample from the poses at its ends.
ImuSample Between(const LocalFrame& frame, const EarthStep& step, const MapPose& i,
                  const MapPose& j) {
  const Eigen::Matrix3d R_bm = i.q_mb.toRotationMatrix().transpose();
  const Eigen::Vector3d& w_m = frame.w_ie_m();
  const Eigen::Vector3d phi =
      Log(Eigen::Quaterniond(R_bm * step.C * j.q_mb.toRotationMatrix()).normalized());
  const Eigen::Vector3d dv_m =
      step.C * (j.v_m + w_m.cross(j.p_mb)) - (i.v_m + w_m.cross(i.p_mb)) +
      step.origin_velocity_mps -
      0.5 * step.dt_s * (frame.Gravitation(i.p_mb) + step.C * frame.Gravitation(j.p_mb));
  return {j.t_s, step.dt_s, phi / step.dt_s,
          RightJacobianInverse(-phi) * (R_bm * dv_m) / step.dt_s};
}

}  // namespace

ImuData ImpliedImu(const LocalFrame& frame, const std::vector<MapPose>& motion, double rate_hz) {
  const double span_s = motion.empty() ? 0.0 : motion.back().t_s - motion.front().t_s;
  const double samples = std::floor(span_s * rate_hz * (1.0 + 1e-12));
  if (!(rate_hz > 0.0) || !(samples >= 1.0)) {
    throw InvalidInput("implied IMU: a motion of " + std::to_string(span_s) +
                       " s is too short for a sample at " + std::to_string(rate_hz) + " Hz");
  }
  ImuData imu;
  imu.nominal_dt_s = 1.0 / rate_hz;
  MapPose begin = motion.front();
  for (double k = 1.0; k <= samples; ++k) {
    const double t_s = std::min(motion.front().t_s + k / rate_hz, motion.back().t_s);
    const MapPose end = InterpolatePose(motion, t_s);
    imu.samples.push_back(Between(frame, EarthStep::Make(frame, t_s - begin.t_s), begin, end));
    begin = end;
  }
  return imu;
}

}  // namespace dn
