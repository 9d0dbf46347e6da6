#include "effects.h"

namespace dn::builder_internal {
namespace {

/// tag = t + value.
class TimeOffset final : public GnssEffect {
 public:
  int components() const override { return 1; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               GnssReading* reading) const override {
    reading->delay_s += value[0];
    reading->J_delay[column] = 1.0;
  }
};

/// tag = t + value (t - first). A constant offset shifts all tags equally, so that t - first = (tag
/// - first tag) / (1 + value).
class GnssTagDrift final : public GnssEffect {
 public:
  explicit GnssTagDrift(double first_tag_s) : first_tag_s_(first_tag_s) {}

  int components() const override { return 1; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               GnssReading* reading) const override {
    const double since_s = (reading->tag_s - first_tag_s_) / (1.0 + value[0]);
    reading->delay_s += value[0] * since_s;
    reading->J_delay[column] = since_s / (1.0 + value[0]);
  }

 private:
  double first_tag_s_;
};

}  // namespace

EffectAction GnssTimeOffset(const EffectSite&) { return std::make_shared<TimeOffset>(); }

EffectAction GnssTimeDrift(const EffectSite& site) {
  const bool any = site.flight.gnss && !site.flight.gnss->epochs.empty();
  return std::make_shared<GnssTagDrift>(any ? site.flight.gnss->epochs.front().t_s : 0.0);
}

}  // namespace dn::builder_internal
