#include <dn/error.h>
#include <dn/factors/prepared_pair.h>
#include <dn/rotation.h>

#include <string>

namespace dn {

Eigen::Matrix3d EndNoise(const LidarEnd& end, const Eigen::Matrix3d& R_mb,
                         const Eigen::Vector3d& l_b) {
  Eigen::Matrix<double, 3, 9> J_x_increments;
  J_x_increments << -R_mb * end.partial.delta_q.toRotationMatrix() * Skew(l_b),
      Eigen::Matrix3d::Zero(), R_mb;
  const auto& covariance = end.bridge ? end.bridge->covariance() : end.partial.covariance;
  return J_x_increments * covariance * J_x_increments.transpose();
}

namespace factors_internal {

void CheckEnd(const char* what, const LidarEnd& end) {
  if (!end.u_s.allFinite() || !(end.u_s.norm() > 0.0)) {
    throw InvalidInput(std::string(what) + ": the laser vector at t = " +
                       std::to_string(end.partial.t_end_s) + " s is zero or not finite");
  }
  if (!end.p_nominal_m.allFinite()) {
    throw InvalidInput(std::string(what) + ": the nominal position at t = " +
                       std::to_string(end.partial.t_begin_s) + " s is not finite");
  }
}

void CheckMounting(const char* what, const Eigen::Matrix3d& R_bs) {
  constexpr double kTolerance = 1e-6;  // allows for a matrix written with seven digits
  const double defect = (R_bs * R_bs.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(defect < kTolerance) || R_bs.determinant() < 0.0) {
    throw InvalidInput(std::string(what) +
                       ": the mounting matrix is not a rotation (R R^T differs from the identity "
                       "by " +
                       std::to_string(defect) + ", determinant " +
                       std::to_string(R_bs.determinant()) + ")");
  }
}

void CheckPreparedPair(const PreparedPair& pair) {
  CheckMounting("point pair", pair.R_bs_nominal);
  if (pair.R_bs_nominal_j) CheckMounting("point pair", *pair.R_bs_nominal_j);
  CheckEnd("point pair", pair.i);
  CheckEnd("point pair", pair.j);
}

}  // namespace factors_internal

}  // namespace dn
