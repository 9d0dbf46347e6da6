#include <dn/error.h>
#include <dn/factors/gnss_antenna.h>
#include <dn/rotation.h>

#include "vector_kind.h"

namespace dn {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kFirstEffect = 4;

std::vector<BlockKind> Kinds(const GnssEffects& effects) {
  std::vector<BlockKind> kinds{Rotation::kKind, Vec<3>::kKind, Vec<3>::kKind, Vec<3>::kKind};
  for (const auto& effect : effects)
    kinds.push_back(factors_internal::VectorKind(effect->components()));
  return kinds;
}

}  // namespace

GnssReading Corrected(const GnssEffects& effects, double const* const* values, double tag_s) {
  Eigen::Index columns = 0;
  for (const auto& effect : effects) columns += effect->components();
  GnssReading reading = GnssReading::Uncorrected(tag_s, columns);
  Eigen::Index column = 0;
  for (const auto& effect : effects) {
    const int size = effect->components();
    effect->Correct(Eigen::Map<const VectorXd>(*values++, size), column, &reading);
    column += size;
  }
  return reading;
}

GnssAntenna::GnssAntenna(Quantity quantity, const Vector3d& z_m, const MotionNearTag& motion,
                         GnssEffects effects, const Noise<3>& noise)
    : DynamicFactor(3, Kinds(effects)),
      quantity_(quantity),
      z_m_(z_m),
      motion_(motion),
      effects_(std::move(effects)),
      W_(noise.sqrt_information()) {
  if (!z_m.allFinite()) throw InvalidInput("GNSS position or velocity is not finite");
  if (!motion.w_ib_b_radps.allFinite() || !motion.a_m_mps2.allFinite()) {
    throw InvalidInput("motion of the body at a GNSS epoch is not finite");
  }
}

bool GnssAntenna::Evaluate(double const* const* x, double* r, double** J) const {
  using Vec3 = Eigen::Map<const Vector3d>;
  const Matrix3d R = Eigen::Quaterniond(x[0]).toRotationMatrix();
  const Vec3 p(x[1]), v(x[3]);
  const GnssReading reading = Corrected(effects_, x + kFirstEffect, motion_.tag_s);
  const Vector3d a_b = Vec3(x[2]) + reading.arm_b_m;
  const double d = reading.delay_s - motion_.node_lead_s;
  const Vector3d w = motion_.w_ib_b_radps - R.transpose() * motion_.w_ie_m_radps;
  const Vector3d phi = -d * w;
  const Matrix3d turn = Exp(phi).toRotationMatrix();
  const bool position = quantity_ == Quantity::kPosition;
  const Vector3d arm = position ? a_b : Vector3d(w.cross(a_b));
  const Vector3d& a_m = motion_.a_m_mps2;
  Vector3d at;
  if (position) {
    at = p - d * v + 0.5 * d * d * a_m + reading.shift_m;
  } else {
    at = v - d * a_m;
  }
  Eigen::Map<Vector3d>(r).noalias() = W_ * (at + R * (turn * arm) - z_m_);
  if (J == nullptr) return true;

  // d w = -[R^T w_ie]x d phi_b: a change of attitude changes the body's rate with respect to the
  // Earth.
  const Matrix3d w_q = -Skew(Vector3d(R.transpose() * motion_.w_ie_m_radps));
  const Matrix3d turned_by_w = turn * Skew(arm) * RightJacobian(phi) * d;
  Matrix3d J_q = -R * Skew(Vector3d(turn * arm)) + R * turned_by_w * w_q;
  if (!position) J_q -= R * turn * Skew(a_b) * w_q;
  Put(0, x, J, Matrix3d(W_ * J_q));
  Put(1, x, J, Matrix3d(position ? W_ : Matrix3d::Zero()));
  const Matrix3d by_arm = R * turn * (position ? Matrix3d(Matrix3d::Identity()) : Skew(w));
  Put(2, x, J, Matrix3d(W_ * by_arm));
  Put(3, x, J, Matrix3d(position ? Matrix3d(-d * W_) : W_));
  const Vector3d by_delay =
      (position ? Vector3d(d * a_m - v) : Vector3d(-a_m)) - R * (turn * w.cross(arm));
  Matrix3Xd J_r_c = by_delay * reading.J_delay + by_arm * reading.J_arm;
  if (position) J_r_c += reading.J_shift;
  J_r_c = W_ * J_r_c;
  Eigen::Index column = 0;
  for (std::size_t k = 0; k < effects_.size(); ++k) {
    const int size = effects_[k]->components();
    Put(kFirstEffect + static_cast<int>(k), x, J, Matrix3Xd(J_r_c.middleCols(column, size)));
    column += size;
  }
  return true;
}

}  // namespace dn
