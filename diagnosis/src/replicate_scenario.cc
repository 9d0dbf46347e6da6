#include <dn/builder/gnss_factors.h>
#include <dn/diagnosis/adapt.h>
#include <dn/diagnosis/replicate_scenario.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/median.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "median_sigmas.h"
#include "scanned_ground.h"

namespace dn {
namespace {

using Eigen::Vector3d;

// Parts that a replay omits at the start of its trajectory and, at most, at its end.
constexpr double kLeftOutAtBegin_s = 1.0;
constexpr double kLeftOutAtEnd_s = 3.5;
constexpr double kShortestStrip_s = 1.0;
constexpr double kSlowestImu_hz = 10.0;  // lowest rate that is simulated
constexpr double kFastestImu_hz = 2000.0;
constexpr double kGroundBelow_m = 100.0;
constexpr double kSecondsPerWeek = 604800.0;

/// Rounds to a millionth, the accuracy of differences of time tags.
double RoundedRate(double step_s) { return std::round(1e6 / step_s) * 1e-6; }

/// Returns the strips, cut to the replayed part of the flight, with names that are allowed in
/// files.
std::vector<StripInterval> ReplayedStrips(const Flight& flight, const Trajectory& trajectory) {
  std::vector<StripInterval> strips;
  for (StripInterval strip : FindStrips(flight)) {
    strip.t0_s = std::max(strip.t0_s, trajectory.t_begin_s() + kLeftOutAtBegin_s);
    strip.t1_s = std::min(strip.t1_s, trajectory.t_end_s() - kLeftOutAtEnd_s);
    if (strip.t1_s - strip.t0_s >= kShortestStrip_s) strips.push_back(std::move(strip));
  }
  const auto odd = [](unsigned char c) { return std::isalnum(c) == 0 && c != '-'; };
  const bool plain = std::all_of(strips.begin(), strips.end(), [&](const StripInterval& strip) {
    return !strip.name.empty() && std::none_of(strip.name.begin(), strip.name.end(), odd);
  });
  for (std::size_t i = 0; !plain && i < strips.size(); ++i) strips[i].name = std::to_string(i + 1);
  return strips;
}

ImuScenario MakeImu(const Flight& flight) {
  ImuScenario imu;
  imu.rate_hz = std::clamp(RoundedRate(flight.imu->nominal_dt_s), kSlowestImu_hz, kFastestImu_hz);
  imu.model = flight.config.imu->model;
  imu.model.vibration.clear();  // simulated as effects
  return imu;
}

/// Returns the vibration that flight.yaml states as effects, the only form that a scenario has for
/// it.
std::vector<Effect> VibrationEffects(const Flight& flight) {
  const EffectSpec& spec = EffectRow(EffectId::kImuVibration);
  std::vector<Effect> effects;
  for (const ImuVibration& v : flight.config.imu->model.vibration) {
    Effect entry{spec.name,
                 {v.gyro_sigma_radps / spec.components[0].to_si,
                  v.accel_sigma_mps2 / spec.components[1].to_si},
                 {},
                 {}};
    entry.times.window_s = {v.t0_s, v.t1_s};
    effects.push_back(std::move(entry));
  }
  return effects;
}

GnssScenario MakeGnss(const Flight& flight) {
  const GnssConfig& config = *flight.config.gnss;
  const std::vector<MapGnssEpoch>& epochs = flight.gnss->epochs;
  GnssScenario gnss;
  std::vector<double> step_s;
  for (std::size_t i = 1; i < epochs.size(); ++i) {
    step_s.push_back(epochs[i].t_s - epochs[i - 1].t_s);
  }
  if (!step_s.empty()) gnss.rate_hz = RoundedRate(Median(step_s));
  gnss.sigma_enu_m = diagnosis_internal::MedianGnssSigma(flight);
  gnss.lever_arm_b_m = config.lever_arm_b_m;
  gnss.velocity = UsesVelocities(flight);
  gnss.processes = config.processes;
  return gnss;
}

void AddLidar(const Flight& flight, const Trajectory& trajectory, const Vector3d& boresight_rad,
              Scenario* scenario) {
  Mounting mounting = flight.config.lidar->mounting;
  mounting.boresight_rad = boresight_rad;
  scenario->lidar = EstimateScanner(flight, mounting);
  scenario->terrain = EstimateGround(flight, trajectory, mounting, scenario->plan.strips);
  scenario->pairs.count = static_cast<long>(flight.pairs->pairs.size());
  scenario->pairs.sigma_p_m = diagnosis_internal::MedianPairSigma(flight);
}

/// Adds flat ground below the path, for a scenario without pairs.
void AddNoLidar(const Flight& flight, const Trajectory& trajectory, Scenario* scenario) {
  double lowest_m = std::numeric_limits<double>::infinity();
  for (const MapPose& pose : trajectory.ToMapPoses(flight.frame)) {
    lowest_m = std::min(lowest_m, pose.p_mb.z());
  }
  scenario->terrain.kind = TerrainKind::kFlat;
  scenario->terrain.base_m = lowest_m - kGroundBelow_m;
  scenario->terrain.wavelength_m = 1000.0;
  scenario->lidar.fov_rad = 1.0;
  scenario->lidar.gsd_m = 1.0;
  scenario->lidar.pulse_rate_hz = 100000.0;
  scenario->pairs.sigma_p_m = 1.0;
}

}  // namespace

Scenario MakeReplicateScenario(const Flight& flight, const Trajectory& estimated,
                               const std::vector<GapCause>& causes, const Vector3d& boresight_rad) {
  if (!flight.imu || !flight.gnss)
    throw InvalidInput("a replicate needs a flight with IMU and GNSS data");
  Scenario scenario;
  scenario.name = flight.config.name + " twin";
  scenario.origin = flight.frame.origin();
  scenario.start_s = std::fmod(std::max(0.0, estimated.t_begin_s()), kSecondsPerWeek);
  scenario.plan.replay = kReplayTrajectoryFile;
  scenario.plan.strips = ReplayedStrips(flight, estimated);
  scenario.plan.bank_rad = 25.0 * kRadPerDeg;  // used by lines only, not by a replay
  scenario.imu = MakeImu(flight);
  scenario.gnss = MakeGnss(flight);
  if (flight.pairs && flight.config.lidar && !flight.pairs->pairs.empty()) {
    AddLidar(flight, estimated, boresight_rad, &scenario);
  } else {
    AddNoLidar(flight, estimated, &scenario);
  }
  scenario.effects = VibrationEffects(flight);
  for (const GapCause& cause : causes) {
    scenario.effects.push_back({cause.effect, ToFileValue(cause), cause.times, {}});
  }
  return scenario;
}

}  // namespace dn
