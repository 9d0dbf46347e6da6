#include <dn/error.h>

#include "effects.h"

namespace dn::builder_internal {
namespace {

/// Drift: true boresight = boresight + value (t - middle). Step: true boresight = boresight + value
/// from a given time on.
class BoresightMotion final : public LidarEffect {
 public:
  BoresightMotion(bool drift, double t0_s) : drift_(drift), t0_s_(t0_s) {}

  int components() const override { return 3; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    const double since_s = reading->tag_s - reading->delay_s - t0_s_;
    const double share = drift_ ? since_s : (since_s >= 0.0 ? 1.0 : 0.0);
    reading->turn_b_rad += share * value;
    if (drift_) reading->J_turn -= value * reading->J_delay;
    reading->J_turn.middleCols<3>(column) = share * Eigen::Matrix3d::Identity();
  }

 private:
  bool drift_;
  double t0_s_;
};

}  // namespace

EffectAction BoresightDrift(const EffectSite& site) {
  const auto [first_s, last_s] = LidarSpan(site.flight);
  return std::make_shared<BoresightMotion>(true, 0.5 * (first_s + last_s));
}

EffectAction BoresightStep(const EffectSite& site) {
  if (!site.times.t0_s)
    throw InvalidConfig("estimate: boresight_step needs the time t0_s of the step");
  return std::make_shared<BoresightMotion>(false, *site.times.t0_s);
}

}  // namespace dn::builder_internal
