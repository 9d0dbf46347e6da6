#include <dn/lidar/point_covariance.h>
#include <dn/rotation.h>

namespace dn {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d PointCovariance(const MapPose& pose, const Mounting& mounting, const Vector3d& u_s,
                         const PointErrors& errors) {
  const Vector3d u_b = LaserVectorInBody(mounting, u_s);
  const Matrix3d attitude = Skew((u_b + mounting.lever_arm_b_m).eval());
  const Matrix3d boresight = Skew(u_b);
  const double range2_m2 = u_b.squaredNorm();
  const Matrix3d along = u_b * u_b.transpose() / range2_m2;
  const double across_m2 = errors.sigma_beam_rad * errors.sigma_beam_rad * range2_m2;
  const Matrix3d C_b = attitude * errors.attitude_rad2 * attitude.transpose() +
                       boresight * errors.boresight_rad2 * boresight.transpose() +
                       errors.sigma_range_m * errors.sigma_range_m * along +
                       across_m2 * (Matrix3d::Identity() - along);
  const Matrix3d R_mb = pose.q_mb.toRotationMatrix();
  return errors.position_m2 + R_mb * C_b * R_mb.transpose();
}

}  // namespace dn
