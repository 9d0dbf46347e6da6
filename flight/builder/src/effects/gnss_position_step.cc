#include <dn/error.h>

#include "effects.h"

namespace dn::builder_internal {
namespace {

/// A constant offset (east, north, up) of the positions during a time window.
class PositionStep final : public GnssEffect {
 public:
  PositionStep(const Eigen::Matrix3d& R_m_enu, const std::pair<double, double>& window_s)
      : R_m_enu_(R_m_enu), window_s_(window_s) {}

  int components() const override { return 3; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               GnssReading* reading) const override {
    const double t_s = reading->tag_s - reading->delay_s;
    if (t_s < window_s_.first || t_s > window_s_.second) return;
    reading->shift_m += R_m_enu_ * value;
    reading->J_shift.middleCols<3>(column) = R_m_enu_;
  }

 private:
  Eigen::Matrix3d R_m_enu_;
  std::pair<double, double> window_s_;
};

/// Returns the ENU axes at the middle of the flight. Over 10 km they turn by 2 mrad, which changes
/// a step of one metre by 2 mm.
Eigen::Matrix3d MiddleEnuAxes(const Flight& flight) {
  if (!flight.gnss || flight.gnss->epochs.empty()) return flight.frame.R_m_enu({0.0, 0.0, 0.0});
  const auto& epochs = flight.gnss->epochs;
  return epochs[epochs.size() / 2].R_m_enu;
}

}  // namespace

EffectAction GnssPositionStep(const EffectSite& site) {
  if (!site.times.window_s) {
    throw InvalidConfig("estimate: gnss_position_step needs the time window of the step");
  }
  return std::make_shared<PositionStep>(MiddleEnuAxes(site.flight), *site.times.window_s);
}

}  // namespace dn::builder_internal
