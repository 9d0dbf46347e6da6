#include <dn/error.h>
#include <dn/lidar/mounting.h>
#include <dn/rotation.h>

#include <Eigen/SVD>
#include <string>

namespace dn {
namespace {

constexpr double kRotationTolerance = 1e-6;  // matrices typed by hand have six digits or more
constexpr double kRoundOff = 1e-14;  // orthonormality error that a product of rotations can have

double OrthonormalityError(const Eigen::Matrix3d& R) {
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

}  // namespace

Eigen::Matrix3d CheckedRotation(const Eigen::Matrix3d& R) {
  if (!R.allFinite()) throw InvalidInput("rotation matrix has an element that is not finite");
  const double error = OrthonormalityError(R);
  if (error > kRotationTolerance) {
    throw InvalidInput("matrix is not a rotation: R^T R differs from the identity by " +
                       std::to_string(error) + ", but at most 1e-6 is allowed");
  }
  if (R.determinant() < 0.0) {
    throw InvalidInput(
        "matrix is not a rotation but a reflection (determinant -1): one axis has the wrong sign");
  }
  if (error <= kRoundOff) return R;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Eigen::Vector3d LaserVectorInBody(const Mounting& mounting, const Eigen::Vector3d& u_s) {
  return Exp(mounting.boresight_rad) * (mounting.R_bs_nominal * u_s);
}

Eigen::Vector3d Georeference(const MapPose& pose, const Mounting& mounting,
                             const Eigen::Vector3d& u_s) {
  return pose.p_mb + pose.q_mb * (LaserVectorInBody(mounting, u_s) + mounting.lever_arm_b_m);
}

Eigen::Vector3d LaserVectorInSensor(const Mounting& mounting, const Eigen::Vector3d& u_b) {
  return mounting.R_bs_nominal.transpose() * (Exp(mounting.boresight_rad).conjugate() * u_b);
}

Eigen::Vector3d LaserVectorTo(const MapPose& pose, const Mounting& mounting,
                              const Eigen::Vector3d& p_m) {
  return LaserVectorInSensor(mounting,
                             pose.q_mb.conjugate() * (p_m - pose.p_mb) - mounting.lever_arm_b_m);
}

}  // namespace dn
