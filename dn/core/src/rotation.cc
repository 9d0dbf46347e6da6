#include <dn/rotation.h>

#include <algorithm>

namespace dn {

Eigen::Matrix3d RightJacobian(const Eigen::Vector3d& phi) {
  const double angle2 = phi.squaredNorm();
  const Eigen::Matrix3d S = Skew(phi);
  double a, b;  // J = I - a S + b S^2
  if (angle2 > 1e-6) {
    const double angle = std::sqrt(angle2);
    const double sine = std::sin(0.5 * angle);
    a = 2.0 * sine * sine / angle2;  // (1 - cos) / angle^2 without cancellation
    b = (angle - std::sin(angle)) / (angle2 * angle);
  } else {
    a = 0.5 - angle2 / 24.0 + angle2 * angle2 / 720.0;
    b = 1.0 / 6.0 - angle2 / 120.0 + angle2 * angle2 / 5040.0;
  }
  return Eigen::Matrix3d::Identity() - a * S + b * S * S;
}

Eigen::Matrix3d RightJacobianInverse(const Eigen::Vector3d& phi) {
  const double angle2 = phi.squaredNorm();
  const Eigen::Matrix3d S = Skew(phi);
  double b;  // J^-1 = I + S/2 + b S^2
  if (angle2 > 1e-4) {
    const double angle = std::sqrt(angle2);
    b = 1.0 / angle2 - 0.5 / (angle * std::tan(0.5 * angle));
  } else {
    b = 1.0 / 12.0 + angle2 / 720.0 + angle2 * angle2 / 30240.0;
  }
  return Eigen::Matrix3d::Identity() + 0.5 * S + b * S * S;
}

Eigen::Quaterniond QuaternionFromRollPitchHeading(const Eigen::Vector3d& rph_rad) {
  return Eigen::AngleAxisd(rph_rad.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(rph_rad.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(rph_rad.x(), Eigen::Vector3d::UnitX());
}

Eigen::Vector3d RollPitchHeading(const Eigen::Quaterniond& q_nb) {
  const Eigen::Matrix3d R_nb = q_nb.normalized().toRotationMatrix();
  return {std::atan2(R_nb(2, 1), R_nb(2, 2)), -std::asin(std::clamp(R_nb(2, 0), -1.0, 1.0)),
          std::atan2(R_nb(1, 0), R_nb(0, 0))};
}

}  // namespace dn
