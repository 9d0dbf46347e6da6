#include "gnss_clock.h"

#include <dn/builder/calibration_effect.h>
#include <dn/effects/effect_table.h>

#include <algorithm>

namespace dn::adjustment_internal {
namespace {

void AddToEffect(const Flight& flight, EffectId id, double more, CalibrationState* calibration) {
  for (CalibrationValue& effect : calibration->effects) {
    if (!IsEffect(effect.name, id)) continue;
    effect.value[0] += more;
    return;
  }
  calibration->Insert(
      {EffectName(id), FindEstimable(id)->make({flight}), Eigen::VectorXd::Constant(1, more)});
}

}  // namespace

void EstimateGnssClock(FlightConfig* config) {
  for (const EffectId id : {EffectId::kGnssTimeOffset, EffectId::kGnssTimeDrift}) {
    const bool is_unknown = std::ranges::any_of(
        config->estimate, [&](const EstimateEntry& entry) { return IsEffect(entry.unknown, id); });
    if (!is_unknown) config->estimate.push_back({.unknown = EffectName(id)});
  }
}

void AddToGnssClock(const Flight& flight, double offset_s, double drift,
                    CalibrationState* calibration) {
  AddToEffect(flight, EffectId::kGnssTimeOffset, offset_s, calibration);
  AddToEffect(flight, EffectId::kGnssTimeDrift, drift, calibration);
}

}  // namespace dn::adjustment_internal
