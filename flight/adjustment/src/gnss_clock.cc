#include "gnss_clock.h"

#include <dn/adjustment/adjust.h>
#include <dn/builder/calibration_effect.h>
#include <dn/effects/effect_table.h>
#include <dn/navigation/gnss_lag.h>
#include <dn/report/value_words.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

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

constexpr const char* kTagRemedy =
    "correct the tags (gnss.time_offset_s), or check the time systems of both files and the leap "
    "seconds of the program that wrote them";

std::string LateOrEarly(double offset_s) { return offset_s > 0.0 ? "late" : "early"; }

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

void FailFarClock(const Flight& flight, double offset_s, double sigma_s) {
  throw SensorsContradict("the GNSS time tags are " + FormatWithSigma(std::abs(offset_s), sigma_s) +
                              " s " + LateOrEarly(offset_s) +
                              " against those of the inertial data: ",
                          kTagRemedy, {flight.config.gnss->file});
}

void ExpectCommonTime(const Flight& flight) {
  const std::optional<GnssLag> lag = FindGnssLag(flight);
  if (!lag) return;
  if (lag->certain) FailFarClock(flight, lag->lag_s, lag->sigma_s);
  throw SensorsContradict(
      "the motion of the GNSS positions is not that of the inertial data; it fits better, but not "
      "with certainty, if the time tags are " +
          fmt::format("{:.1f} s {}", std::abs(lag->lag_s), LateOrEarly(lag->lag_s)) + ": ",
      std::string(kTagRemedy) + "; or the files are not of the same flight",
      {flight.config.gnss->file});
}

}  // namespace dn::adjustment_internal
