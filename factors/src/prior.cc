#include <dn/error.h>
#include <dn/factors/prior.h>
#include <dn/rotation.h>

namespace dn {
namespace {

Eigen::Quaterniond CheckedInverse(const Eigen::Quaterniond& q0) {
  if (!q0.coeffs().allFinite()) throw InvalidInput("rotation of a prior is not finite");
  if (q0.norm() == 0.0) throw InvalidInput("rotation of a prior has zero norm");
  return q0.normalized().conjugate();
}

}  // namespace

PriorRotation::PriorRotation(const Eigen::Quaterniond& q0, const Noise<3>& noise)
    : q0_inverse_(CheckedInverse(q0)), W_(noise.sqrt_information()) {}

bool PriorRotation::Evaluate(double const* const* x, double* r, double** J) const {
  const Eigen::Map<const Eigen::Quaterniond> q(x[0]);
  const Eigen::Vector3d phi = Log(Eigen::Quaterniond(q0_inverse_ * q));
  Put<0>(x, J, W_ * RightJacobianInverse(phi));
  return Residual(x[0], r);
}

PriorLeftRotation::PriorLeftRotation(const Eigen::Quaterniond& q0, const Noise<3>& noise)
    : q0_inverse_(CheckedInverse(q0)), W_(noise.sqrt_information()) {}

bool PriorLeftRotation::Evaluate(double const* const* x, double* r, double** J) const {
  const Eigen::Map<const Eigen::Quaterniond> q(x[0]);
  const Eigen::Vector3d phi = Log(Eigen::Quaterniond(q * q0_inverse_));
  Put<0>(x, J, W_ * RightJacobianInverse(-phi));
  return Residual(x[0], r);
}

}  // namespace dn
