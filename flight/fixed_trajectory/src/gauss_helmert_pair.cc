#include "gauss_helmert_pair.h"

#include <dn/rotation.h>

#include <algorithm>

namespace dn {
namespace fixed_trajectory_internal {
namespace {

// Returns R [u]x.
Eigen::Matrix3d TimesSkew(const Eigen::Matrix3d& R, const Eigen::Vector3d& u) {
  Eigen::Matrix3d out;
  out.col(0) = u.z() * R.col(1) - u.y() * R.col(2);
  out.col(1) = u.x() * R.col(2) - u.z() * R.col(0);
  out.col(2) = u.y() * R.col(0) - u.x() * R.col(1);
  return out;
}

}  // namespace

Eigen::Vector3d BodyVector(const Eigen::Vector3d& u_b, BoresightModel model,
                           const Eigen::Vector3d& theta_rad,
                           const Eigen::Quaterniond& q_boresight) {
  if (model == BoresightModel::kExponential) return q_boresight * u_b;
  return u_b + theta_rad.cross(u_b);
}

EndTerms EvaluateEnd(const GaussHelmertEnd& end, const Eigen::Vector3d& u_b,
                     const Eigen::Vector3d& lever_arm_b_m, BoresightModel model,
                     const Eigen::Vector3d& theta_rad, const Eigen::Quaterniond& q_boresight,
                     const Eigen::Vector3d& v_p, const Eigen::Vector3d& v_phi) {
  const Eigen::Vector3d u = BodyVector(u_b, model, theta_rad, q_boresight);
  const Eigen::Vector3d s = u + lever_arm_b_m;
  const bool corrected = !v_phi.isZero(0.0);
  EndTerms terms;
  terms.R = (corrected ? Eigen::Quaterniond(end.q_mb * Exp(v_phi)) : end.q_mb).toRotationMatrix();
  terms.x = end.p_mb + v_p + terms.R * s;
  terms.J_theta = -TimesSkew(terms.R, model == BoresightModel::kExponential ? u : u_b);
  terms.J_phi = -TimesSkew(terms.R, s);
  if (corrected) terms.J_phi = terms.J_phi * RightJacobian(v_phi);
  return terms;
}

void LaserColumns::Add(const LaserTerms& terms, const Eigen::Matrix3d& J) {
  for (const LaserTerm& term : terms) {
    if (term.unknown < 0) continue;
    const auto past = unknown.begin() + size();
    const auto known = std::find(unknown.begin(), past, term.unknown);
    const auto column = known - unknown.begin();
    if (known == past) {
      unknown[static_cast<std::size_t>(column)] = term.unknown;
      A.conservativeResize(Eigen::NoChange, column + 1);
      A.col(column).setZero();
    }
    A.col(column) += J * term.direction_b;
  }
}

LaserColumns PairLaserColumns(const GaussHelmertPair& pair, BoresightModel model,
                              const Eigen::Vector3d& theta_rad, const PairCorrection& v) {
  const Eigen::Matrix3d R_boresight = model == BoresightModel::kExponential
                                          ? Exp(theta_rad).toRotationMatrix()
                                          : Eigen::Matrix3d::Identity() + Skew(theta_rad);
  const auto J = [&](const GaussHelmertEnd& end, Eigen::Index attitude) {
    return Eigen::Matrix3d(
        (end.q_mb * Exp(Eigen::Vector3d(v.segment<3>(attitude)))).toRotationMatrix() * R_boresight);
  };
  LaserColumns columns;
  columns.Add(pair.i.laser, J(pair.i, 3));
  columns.Add(pair.j.laser, -J(pair.j, 9));
  return columns;
}

PoseNoise EvaluateNoise(const GaussHelmertEnd& end) {
  const Eigen::Matrix3d R_mn = end.q_mn.toRotationMatrix();
  const Eigen::Matrix3d L = R_mn * end.sigma_ned_m.asDiagonal();
  const Eigen::Vector3d down_b = end.q_mb.conjugate() * Eigen::Vector3d(R_mn.col(2));
  PoseNoise noise;
  noise.position.noalias() = L * L.transpose();
  noise.attitude_factor = BodyFromEulerRates(down_b) * end.sigma_rph_rad.asDiagonal();
  return noise;
}

}  // namespace fixed_trajectory_internal

PairLinearisation LinearisePair(const GaussHelmertPair& pair, const Eigen::Vector3d& lever_arm_b_m,
                                BoresightModel model, const Eigen::Vector3d& theta_rad,
                                const PairCorrection& v) {
  const Eigen::Quaterniond q_boresight = Exp(theta_rad);
  const fixed_trajectory_internal::EndTerms i =
      fixed_trajectory_internal::EvaluateEnd(pair.i, pair.i.u_b, lever_arm_b_m, model, theta_rad,
                                             q_boresight, v.segment<3>(0), v.segment<3>(3));
  const fixed_trajectory_internal::EndTerms j =
      fixed_trajectory_internal::EvaluateEnd(pair.j, pair.j.u_b, lever_arm_b_m, model, theta_rad,
                                             q_boresight, v.segment<3>(6), v.segment<3>(9));
  PairLinearisation out;
  out.w = i.x - j.x;
  out.A = i.J_theta - j.J_theta;
  out.B << Eigen::Matrix3d::Identity(), i.J_phi, -Eigen::Matrix3d::Identity(), -j.J_phi;
  return out;
}

}  // namespace dn
