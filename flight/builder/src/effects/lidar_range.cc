#include "effects.h"

namespace dn::builder_internal {
namespace {

/// measured range = (1 + scale) true range + offset, where the value is either the scale or the
/// offset.
class Range final : public LidarEffect {
 public:
  explicit Range(bool scale) : scale_(scale) {}

  int components() const override { return 1; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    if (scale_) {
      const double inverse = 1.0 / (1.0 + value[0]);
      reading->u_s *= inverse;
      reading->J_u *= inverse;
      reading->J_u.col(column) = -inverse * reading->u_s;
      return;
    }
    const double range_m = reading->u_s.norm();
    const Eigen::Vector3d e = reading->u_s / range_m;
    reading->u_s -= value[0] * e;
    reading->J_u -= (value[0] / range_m) * (reading->J_u - e * (e.transpose() * reading->J_u));
    reading->J_u.col(column) = -e;
  }

 private:
  bool scale_;
};

}  // namespace

EffectAction LidarRangeOffset(const EffectSite&) { return std::make_shared<Range>(false); }
EffectAction LidarRangeScale(const EffectSite&) { return std::make_shared<Range>(true); }

}  // namespace dn::builder_internal
