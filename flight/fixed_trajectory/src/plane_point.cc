#include <dn/fixed_trajectory/plane_adjustment.h>
#include <dn/rotation.h>

#include "gauss_helmert_pair.h"

namespace dn {

Eigen::Matrix<double, 3, 2> PlaneTangent(const Eigen::Vector3d& normal) {
  Eigen::Matrix<double, 3, 2> tangent;
  tangent.col(0) = normal.unitOrthogonal();
  tangent.col(1) = normal.cross(tangent.col(0));
  return tangent;
}

PlaneState Changed(const PlaneState& plane, const Eigen::Vector3d& t) {
  PlaneState out = plane;
  out.normal = (plane.normal + PlaneTangent(plane.normal) * t.head<2>()).normalized();
  out.d_m += t.z();
  return out;
}

PlanePointLinearisation LinearisePlanePoint(const PlanePoint& point, double sigma_m,
                                            const Eigen::Vector3d& lever_arm_b_m,
                                            const Eigen::Vector3d& theta_rad, double rho_m,
                                            const PlaneState& plane,
                                            const Eigen::VectorXd& laser_change) {
  const GaussHelmertEnd& end = point.end;
  Eigen::Vector3d u_b = end.u_b;
  if (laser_change.size() > 0) u_b += VectorChange(end.laser, laser_change);
  const Eigen::Vector3d along_b = u_b.normalized();
  const Eigen::Quaterniond q_boresight = Exp(theta_rad);
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const fixed_trajectory_internal::EndTerms terms = fixed_trajectory_internal::EvaluateEnd(
      end, u_b - rho_m * along_b, lever_arm_b_m, BoresightModel::kExponential, theta_rad,
      q_boresight, zero, zero);
  const fixed_trajectory_internal::PoseNoise noise = fixed_trajectory_internal::EvaluateNoise(end);
  const Eigen::Vector3d& n = plane.normal;
  const Eigen::Vector3d from_centre = terms.x - plane.centre_m;
  PlanePointLinearisation out;
  out.f_m = n.dot(from_centre) - plane.d_m;
  out.J_theta = terms.J_theta.transpose() * n;
  const Eigen::Vector3d by_u_b = (end.q_mb * q_boresight).conjugate() * n;  // d f / d u_b
  out.J_range = -by_u_b.dot(along_b);
  for (std::size_t k = 0; k < end.laser.size(); ++k) {
    out.J_laser[k] = by_u_b.dot(end.laser[k].direction_b);
  }
  out.J_plane.head<2>() = PlaneTangent(n).transpose() * from_centre;
  out.J_plane.z() = -1.0;
  out.J_phi = terms.J_phi.transpose() * n;
  out.variance_m2 = n.dot(noise.position * n) +
                    (noise.attitude_factor.transpose() * out.J_phi).squaredNorm() +
                    sigma_m * sigma_m;
  return out;
}

PlaneUnknownRow::PlaneUnknownRow(const PlaneProblem& problem, const PlanePoint& point,
                                 const PlanePointLinearisation& linear) {
  const auto add = [this](Eigen::Index index, double derivative) {
    at[size] = index;
    value[size++] = derivative;
  };
  for (Eigen::Index i = 0; i < 3; ++i) add(i, linear.J_theta[i]);
  if (problem.with_range_offset) add(3, linear.J_range);
  for (std::size_t k = 0; k < point.end.laser.size(); ++k) {
    const int unknown = point.end.laser[k].unknown;
    if (unknown >= 0) add(problem.FirstLaser() + unknown, linear.J_laser[k]);
  }
}

}  // namespace dn
