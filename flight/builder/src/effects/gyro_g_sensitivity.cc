#include "effects.h"

namespace dn::builder_internal {
namespace {

/// Adds value (rad/s per m/s^2) times the specific force along the same axis to each angular rate.
class GSensitivity final : public ImuEffect {
 public:
  int components() const override { return 3; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               ImuReading* reading) const override {
    if (!value.isZero(0.0)) {
      const Eigen::Vector3d rate_per_force = value;
      reading->w_b -= rate_per_force.cwiseProduct(reading->f_b);
      reading->J_w -= rate_per_force.asDiagonal() * reading->J_f;
    }
    reading->J_w.middleCols<3>(column).diagonal() = -reading->f_b;
  }
};

}  // namespace

EffectAction GyroGSensitivity(const EffectSite&) { return std::make_shared<GSensitivity>(); }

}  // namespace dn::builder_internal
