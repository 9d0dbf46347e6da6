#include "gnss_effects.h"

#include <dn/error.h>
#include <dn/sim/random.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "effects.h"

namespace dn {
namespace {

using Eigen::Vector3d;

void MoveAntenna(const LocalFrame& frame, const Vector3d& offset_enu_m, GnssEpoch* epoch) {
  const Vector3d p_m = frame.ToMap(epoch->antenna);
  epoch->antenna = frame.ToGeodetic(p_m + frame.R_m_enu(p_m) * offset_enu_m);
}

// Gauss-Markov in continuous time, sampled at the epochs.
void AddCorrelatedNoise(const Effect& effect, const LocalFrame& frame, Random& random,
                        GnssData* data) {
  const Vector3d sigma_enu_m(effect.value[0], effect.value[1], effect.value[2]);
  const double tau_s = effect.value[3];
  Vector3d state = random.Normal3();
  double t_s = data->epochs.front().t_s;
  for (GnssEpoch& epoch : data->epochs) {
    const double decay = std::exp(-(epoch.t_s - t_s) / tau_s);
    state = decay * state + std::sqrt(1.0 - decay * decay) * random.Normal3();
    t_s = epoch.t_s;
    MoveAntenna(frame, sigma_enu_m.cwiseProduct(state), &epoch);
  }
}

void AddOutliers(const Effect& effect, const LocalFrame& frame, Random& random, GnssData* data) {
  for (GnssEpoch& epoch : data->epochs) {
    const bool wrong = random.Uniform() < effect.value[0];
    const double length_m = effect.value[1] * random.Uniform();
    const Vector3d direction = random.Normal3().normalized();
    if (wrong) MoveAntenna(frame, length_m * direction, &epoch);
  }
}

void CheckOrder(const Scenario& scenario, const GnssData& data) {
  const auto back =
      std::adjacent_find(data.epochs.begin(), data.epochs.end(),
                         [](const GnssEpoch& a, const GnssEpoch& b) { return b.t_s <= a.t_s; });
  if (back != data.epochs.end()) {
    throw InvalidConfig("gnss_clock_step: the tags would step back over an epoch",
                        EffectsNamed(scenario, "gnss_clock_step").front()->where);
  }
}

}  // namespace

void ApplyGnssEffects(const Scenario& scenario, const LocalFrame& frame, std::uint64_t seed,
                      bool noise, GnssData* data) {
  int entry = 0;
  for (const Effect& effect : scenario.effects) {
    Random random(seed, effect.name + " " + std::to_string(entry++));
    if (effect.name == "gnss_correlated_noise" && noise) {
      AddCorrelatedNoise(effect, frame, random, data);
    } else if (effect.name == "gnss_outliers" && noise) {
      AddOutliers(effect, frame, random, data);
    } else if (effect.name == "gnss_position_step") {
      for (GnssEpoch& epoch : data->epochs) {
        if (!effect.During(epoch.t_s)) continue;
        MoveAntenna(frame, {effect.value[0], effect.value[1], effect.value[2]}, &epoch);
      }
    }
  }
  const auto outages = EffectsNamed(scenario, "gnss_outage");
  for (const Effect* outage : outages) {
    std::erase_if(data->epochs, [&](const GnssEpoch& epoch) { return outage->During(epoch.t_s); });
  }
  if (!outages.empty() && data->epochs.empty()) {
    throw InvalidConfig("gnss_outage: no GNSS epoch is left", outages.front()->where);
  }
  for (GnssEpoch& epoch : data->epochs) {
    const double t_s = epoch.t_s;
    epoch.t_s += ScalarEffect(scenario, "gnss_time_offset");
    for (const Effect* step : EffectsNamed(scenario, "gnss_clock_step")) {
      if (t_s >= *step->t0_s) epoch.t_s += step->value[0];
    }
  }
  CheckOrder(scenario, *data);
  for (std::size_t k = 0; k < data->epochs.size(); ++k) {
    data->epochs[k].line = static_cast<long>(k) + 1;
  }
}

}  // namespace dn
