#include "effects.h"

namespace dn::internal {
namespace {

/// tag = t + value.
class TimeOffset final : public GnssEffect {
 public:
  int components() const override { return 1; }

  void Correct(const Eigen::VectorXd& value, Eigen::Index column,
               GnssReading* reading) const override {
    reading->delay_s += value[0];
    reading->J_delay[column] = 1.0;
  }
};

}  // namespace

EffectAction GnssTimeOffset(const EffectSite&) { return std::make_shared<TimeOffset>(); }

}  // namespace dn::internal
