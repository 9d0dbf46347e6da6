#include "gnss_simulation.h"

#include <dn/error.h>
#include <dn/rotation.h>
#include <dn/sim/random.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "antenna_error.h"

namespace dn {
namespace {

using Eigen::Vector3d;

/// Simulates the epochs one after the other.
class Receiver {
 public:
  Receiver(const GnssScenario& gnss, const TruthTrajectory& truth, std::uint64_t seed, bool noise,
           const ActiveEffects& effects)
      : gnss_(gnss),
        truth_(truth),
        effects_(effects),
        lever_arm_b_m_(gnss.lever_arm_b_m + effects.gnss_lever_arm_b_m),
        noise_scale_(noise ? effects.gnss_noise_ratio : 0.0),
        random_(seed, "gnss") {
    for (std::size_t i = 0; noise && i < gnss.processes.size(); ++i) {
      correlated_errors_.emplace_back(gnss.processes[i],
                                      Random(seed, "gnss process " + std::to_string(i)));
    }
  }

  /// Returns the epoch at the true time t_s. `first_s` is the true time of the first epoch in the
  /// file.
  MapGnssEpoch At(double t_s, double first_s) {
    NormalEarth earth;
    const TruthState state = truth_.State(t_s, &earth);
    const Eigen::Matrix3d R_mb = state.pose.q_mb.toRotationMatrix();
    const Vector3d antenna_m = state.pose.p_mb + R_mb * lever_arm_b_m_;
    const Eigen::Matrix3d R_m_enu = truth_.frame().R_m_enu(antenna_m);
    Vector3d error_enu = noise_scale_ * gnss_.sigma_enu_m.cwiseProduct(random_.Normal3());
    const double roll_rad = RollPitchHeading(ToNavPoint(state, earth).q_nb).x();
    for (AntennaError& error_enu_m : correlated_errors_) error_enu += error_enu_m(t_s, roll_rad);
    for (const auto& more_enu_m : effects_.antenna_enu_m) error_enu += more_enu_m(t_s, roll_rad);
    MapGnssEpoch epoch;
    epoch.t_s = Tag(effects_.gnss_tags, t_s) + effects_.gnss_tag_drift * (t_s - first_s);
    epoch.p_m = antenna_m + R_m_enu * error_enu;
    epoch.R_m_enu = truth_.frame().R_m_enu(epoch.p_m);
    epoch.covariance_enu_m2 = gnss_.sigma_enu_m.cwiseAbs2().asDiagonal();
    if (gnss_.velocity) {
      const Vector3d v_m = state.pose.v_m + R_mb * state.w_mb_b.cross(lever_arm_b_m_);
      epoch.velocity_enu_mps =
          R_m_enu.transpose() * v_m +
          noise_scale_ * kGnssVelocitySigma_enu_mps.cwiseProduct(random_.Normal3());
      epoch.velocity_covariance_enu = kGnssVelocitySigma_enu_mps.cwiseAbs2().asDiagonal();
    }
    return epoch;
  }

 private:
  const GnssScenario& gnss_;
  const TruthTrajectory& truth_;
  const ActiveEffects& effects_;
  Vector3d lever_arm_b_m_;  // true value
  double noise_scale_;
  Random random_;
  std::vector<AntennaError> correlated_errors_;
};

}  // namespace

MapGnss SimulateGnss(const GnssScenario& gnss, const TruthTrajectory& truth, std::uint64_t seed,
                     bool noise, const ActiveEffects& effects) {
  Receiver receiver(gnss, truth, seed, noise, effects);
  MapGnss data;
  double before_s = truth.t_begin_s();
  std::optional<double> first_s;
  const auto first = static_cast<long>(std::ceil(truth.t_begin_s() * gnss.rate_hz));
  for (long k = first; static_cast<double>(k) / gnss.rate_hz <= truth.t_end_s(); ++k) {
    const double t_s = static_cast<double>(k) / gnss.rate_hz;
    const bool in_gap = InGap(effects.gnss_gaps, t_s);
    if (!in_gap && !first_s) first_s = t_s;
    MapGnssEpoch epoch = receiver.At(t_s, first_s.value_or(t_s));
    if (in_gap) continue;
    if (!data.epochs.empty() && epoch.t_s <= data.epochs.back().t_s) {
      RefuseStepBack(effects.gnss_tags, before_s, t_s);
    }
    before_s = t_s;
    epoch.line = static_cast<long>(data.epochs.size()) + 1;
    data.epochs.push_back(epoch);
  }
  if (data.epochs.empty() && !effects.gnss_gaps.empty()) {
    const DataGap& gap = effects.gnss_gaps.front();
    throw InvalidConfig(gap.effect + ": no GNSS epoch remains", gap.where);
  }
  return data;
}

}  // namespace dn
