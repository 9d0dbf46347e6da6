#include "clock_estimates.h"

#include <dn/adjustment/unknown_noise.h>
#include <dn/effects/effect_table.h>
#include <dn/files/flight.h>
#include <dn/navigation/gnss_lag.h>

#include <cmath>
#include <optional>
#include <vector>

#include "joint_estimate.h"

namespace dn::diagnosis_internal {
namespace {

// Within these times, the motion of the antenna and of the beam is linear enough for a clock offset
// of first order.
constexpr double kLongestLinearGnss_s = 0.2, kLongestLinearLidar_s = 0.05;

/// Returns the components of an effect in the score; empty if it is an unknown of the network.
std::vector<Eigen::Index> FindComponents(const Library& library, EffectId effect,
                                         const JointScore& score) {
  for (const Hypothesis& hypothesis : library.hypotheses) {
    if (hypothesis.id == effect) return hypothesis.Components(score);
  }
  return {};
}

/// Returns true if noise that was estimated may hide GNSS tags that are far off.
bool NoiseHidesTags(const Flight& flight) {
  return HasUnknownNoise(flight.config) && !GnssTagsFit(flight);
}

/// The effects of a clock, and the largest offset of first order.
struct ClockEffects {
  EffectId offset, drift;
  double longest_linear_s;
};

class ClockEstimator {
 public:
  ClockEstimator(const FlightNetwork& network, const Marginals& marginals, const Library& library,
                 const JointScore& score, const ClockEffects& effects)
      : network_(network),
        marginals_(marginals),
        score_(score),
        effects_(effects),
        offset_(FindComponents(library, effects.offset, score)),
        drift_(FindComponents(library, effects.drift, score)) {}

  std::optional<ClockEstimate> Run() const {
    std::vector<Eigen::Index> components = offset_;
    components.insert(components.end(), drift_.begin(), drift_.end());
    ScoreTest test;
    if (!components.empty()) test = TestJointly(score_, components);
    if (test.dof < static_cast<int>(components.size())) return std::nullopt;
    ClockEstimate clock;
    const auto take = [&](EffectId effect, bool tested, Eigen::Index at, double* value,
                          double* sigma) {
      if (tested) {
        *value = test.estimate[at];
        *sigma = std::sqrt(test.covariance(at, at));
        return;
      }
      const BlockId block = network_.net().Find(EffectName(effect));
      *value = network_.net().block(block).value[0];
      *sigma = std::sqrt(marginals_.Covariance(block)(0, 0));
    };
    take(effects_.offset, !offset_.empty(), 0, &clock.offset_s, &clock.sigma_offset_s);
    if (!offset_.empty() && !IsLinear(clock.offset_s)) return std::nullopt;
    const Eigen::Index after = offset_.empty() ? 0 : 1;
    take(effects_.drift, !drift_.empty(), after, &clock.drift, &clock.sigma_drift);
    if (!offset_.empty() && !drift_.empty()) {
      clock.correlation = test.covariance(0, 1) / (clock.sigma_offset_s * clock.sigma_drift);
    }
    return clock;
  }

 private:
  bool IsLinear(double offset_s) const {
    if (std::abs(offset_s) > effects_.longest_linear_s) return false;
    return effects_.offset != EffectId::kGnssTimeOffset || !NoiseHidesTags(network_.flight());
  }

  const FlightNetwork& network_;
  const Marginals& marginals_;
  const JointScore& score_;
  ClockEffects effects_;
  std::vector<Eigen::Index> offset_, drift_;  // components of the score; empty: an unknown
};

}  // namespace

Clocks EstimateClocks(const FlightNetwork& network, const Marginals& marginals,
                      const Library& library, const JointScore& score) {
  const auto estimate = [&](const ClockEffects& effects) {
    return ClockEstimator(network, marginals, library, score, effects).Run();
  };
  Clocks clocks;
  if (!network.gnss().edges().empty()) {
    clocks.gnss =
        estimate({EffectId::kGnssTimeOffset, EffectId::kGnssTimeDrift, kLongestLinearGnss_s});
  }
  if (!network.pairs().edges().empty()) {
    clocks.lidar =
        estimate({EffectId::kLidarTimeOffset, EffectId::kLidarTimeDrift, kLongestLinearLidar_s});
  }
  return clocks;
}

Eigen::VectorXd ShiftByGnssClock(const ClockEstimate& clock, const Library& library,
                                 const JointScore& score, Eigen::Index watched) {
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(watched);
  const auto add = [&](EffectId effect, double change) {
    for (const Eigen::Index c : FindComponents(library, effect, score)) {
      shift += change * score.shift.col(c).head(watched);
    }
  };
  add(EffectId::kGnssTimeOffset, clock.offset_s);
  add(EffectId::kGnssTimeDrift, clock.drift);
  return shift;
}

}  // namespace dn::diagnosis_internal
