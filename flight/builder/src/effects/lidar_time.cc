#include <algorithm>

#include "effects.h"

namespace dn::builder_internal {
namespace {

/// tag = t + value.
class LidarTagOffset final : public LidarEffect {
 public:
  int components() const override { return 1; }
  bool moves_epochs() const override { return true; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    reading->delay_s += value[0];
    reading->J_delay[column] = 1.0;
  }
};

/// tag = t + value (t - first), so that t = (tag + value first) / (1 + value).
class LidarTagDrift final : public LidarEffect {
 public:
  explicit LidarTagDrift(double first_s) : first_s_(first_s) {}

  int components() const override { return 1; }
  bool moves_epochs() const override { return true; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    const double since_s = (reading->tag_s - first_s_) / (1.0 + value[0]);
    reading->delay_s += value[0] * since_s;
    reading->J_delay[column] = since_s / (1.0 + value[0]);
  }

 private:
  double first_s_;
};

}  // namespace

std::pair<double, double> LidarSpan(const Flight& flight) {
  if (!flight.pairs || flight.pairs->pairs.empty()) {
    const std::vector<StripInterval> strips = FindStrips(flight);
    if (strips.empty()) return {0.0, 0.0};
    return {strips.front().t0_s, strips.back().t1_s};
  }
  const auto& pairs = flight.pairs->pairs;
  std::pair<double, double> span{pairs.front().t_i_s, pairs.front().t_i_s};
  for (const LidarPair& pair : pairs) {
    span.first = std::min({span.first, pair.t_i_s, pair.t_j_s});
    span.second = std::max({span.second, pair.t_i_s, pair.t_j_s});
  }
  return span;
}

EffectAction LidarTimeOffset(const EffectSite&) { return std::make_shared<LidarTagOffset>(); }

Eigen::VectorXd ConfiguredLidarTimeOffset(const FlightConfig&, std::size_t) {
  return Eigen::VectorXd::Zero(1);
}

EffectAction LidarTimeDrift(const EffectSite& site) {
  return std::make_shared<LidarTagDrift>(LidarSpan(site.flight).first);
}

}  // namespace dn::builder_internal
