#include <dn/error.h>

#include "effects.h"

namespace dn::builder_internal {
namespace {

using Eigen::Vector3d;

/// measured = (1 + value) true, for each axis of the gyros or of the accelerometers.
class TriadScaleFactor final : public ImuEffect {
 public:
  explicit TriadScaleFactor(bool gyro) : gyro_(gyro) {}

  int components() const override { return 3; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               ImuReading* reading) const override {
    if (!(value.array() > -1.0).all()) {
      throw InvalidInput(std::string("the estimated scale factor of the ") +
                         (gyro_ ? "gyros" : "accelerometers") +
                         " is below -100 %: check axes and units of the inertial data");
    }
    Vector3d& x = gyro_ ? reading->w_b : reading->f_b;
    Eigen::Matrix3Xd& J = gyro_ ? reading->J_w : reading->J_f;
    if (value.isZero(0.0)) {
      J.middleCols<3>(column).diagonal() = -x;
      return;
    }
    const Vector3d inverse = (1.0 + value.array()).inverse();
    x = inverse.cwiseProduct(x);
    J = inverse.asDiagonal() * J;
    J.middleCols<3>(column).diagonal() = -inverse.cwiseProduct(x);
  }

 private:
  bool gyro_;
};

}  // namespace

EffectAction GyroScaleFactor(const EffectSite&) { return std::make_shared<TriadScaleFactor>(true); }

EffectAction AccelScaleFactor(const EffectSite&) {
  return std::make_shared<TriadScaleFactor>(false);
}

}  // namespace dn::builder_internal
