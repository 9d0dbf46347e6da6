#include <dn/rotation.h>

#include "effects.h"

namespace dn::builder_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// measured = Exp(-[value]x) true, for the gyros or for the accelerometers.
class TriadMisalignment final : public ImuEffect {
 public:
  explicit TriadMisalignment(bool gyro) : gyro_(gyro) {}

  int components() const override { return 3; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               ImuReading* reading) const override {
    const Vector3d phi = value;
    Vector3d& x = gyro_ ? reading->w_b : reading->f_b;
    Eigen::Matrix3Xd& J = gyro_ ? reading->J_w : reading->J_f;
    if (phi.isZero(0.0)) {
      J.middleCols<3>(column) = -Skew(x);
      return;
    }
    const Matrix3d R = Exp(phi).toRotationMatrix();
    x = R * x;
    J = R * J;
    // RightJacobian(-phi) is the left Jacobian of phi.
    J.middleCols<3>(column) = -Skew(x) * RightJacobian(Vector3d(-phi));
  }

 private:
  bool gyro_;
};

}  // namespace

EffectAction GyroMisalignment(const EffectSite&) {
  return std::make_shared<TriadMisalignment>(true);
}

EffectAction AccelMisalignment(const EffectSite&) {
  return std::make_shared<TriadMisalignment>(false);
}

}  // namespace dn::builder_internal
