#include <dn/factors/point_sensitivity.h>
#include <dn/rotation.h>

namespace dn {

PointSensitivity ComputePointSensitivity(const LidarPoint& point, const LidarPoint::Arguments& at,
                                         const LidarPoint::Derivatives& of,
                                         const Eigen::Vector3d& theta_rad,
                                         const Eigen::Matrix3d& W) {
  PointSensitivity out;
  out.lever_arm.noalias() = W * of.a_b;
  out.u_b.noalias() = out.lever_arm * at.q_boresight.toRotationMatrix();
  out.turn_b.noalias() = W * (of.theta * RightJacobian(Eigen::Vector3d(-theta_rad)));
  out.delay.noalias() = -W * of.rate;
  out.increments.noalias() = W * point.IncrementJacobian(at);
  out.attraction.noalias() = W * point.GravitationJacobian(at.ddt_s);
  return out;
}

void AddEffectJacobians(const PointSensitivity& point, const EffectsOnPoint& effects,
                        const Eigen::Matrix3d& R_bs_nominal, Eigen::Ref<Eigen::Matrix3Xd> sum) {
  const LidarReading& reading = effects.reading;
  const Eigen::Index lidar = reading.J_u.cols(), imu = effects.increments.cols();
  const Eigen::Matrix3d by_u_s = point.u_b * R_bs_nominal;
  auto of_lidar = sum.leftCols(lidar);
  of_lidar += by_u_s.lazyProduct(reading.J_u);
  of_lidar += point.turn_b.lazyProduct(reading.J_turn);
  of_lidar += point.lever_arm.lazyProduct(reading.J_arm);
  of_lidar += point.delay.lazyProduct(reading.J_delay);
  auto of_imu = sum.middleCols(lidar, imu);
  of_imu += point.increments.lazyProduct(effects.increments);
  if (effects.whole != nullptr) of_imu += point.whole.lazyProduct(*effects.whole);
  Eigen::Index column = lidar + imu;
  for (const GravitationBasis& D : effects.attraction) {
    sum.middleCols(column, D.cols()) += point.attraction.lazyProduct(D);
    column += D.cols();
  }
}

}  // namespace dn
