#include <dn/error.h>
#include <dn/files/scanners.h>
#include <dn/geo/text_table.h>
#include <dn/rotation.h>
#include <dn/sim/simulate.h>
#include <dn/sim/terrain.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "active_effects.h"
#include "beams.h"
#include "control_simulation.h"
#include "flight_plan.h"
#include "gnss_simulation.h"
#include "imu_simulation.h"
#include "pair_simulation.h"
#include "platform_vibration.h"
#include "replay.h"
#include "scenario_limits.h"

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLowestFlight_m = 10.0;

struct FlownPlan {
  FlightPlan plan;
  double begin_s;
  Disturbance disturbance;
  std::optional<DrydenTurbulence> dryden;
};

FlownPlan Replay(const Trajectory& trajectory, const LocalFrame& frame) {
  return {ReplayFlight(trajectory, frame), trajectory.t_begin_s() + kReplayMargin_s, {}, {}};
}

/// Returns the turbulence of a plan with Dryden's spectra; nullopt with another one. The heights of
/// the lines refer to the mean ground.
std::optional<DrydenTurbulence> Dryden(const Scenario& scenario, double mean_speed_mps) {
  const TurbulenceScenario& turbulence = scenario.plan.turbulence;
  if (turbulence.spectrum != TurbulenceSpectrum::kDryden) return std::nullopt;
  double height_m = 0.0;
  for (const PlannedLine& line : scenario.plan.lines) height_m += line.height_m;
  height_m = height_m / static_cast<double>(scenario.plan.lines.size()) - scenario.terrain.base_m;
  return DrydenTurbulence(turbulence,
                          DrydenGusts::At(height_m, mean_speed_mps, turbulence.wingspan_m),
                          scenario.imu.rate_hz);
}

FlownPlan Plan(const Scenario& scenario, const LocalFrame& frame, std::uint64_t seed,
               const Trajectory* replay) {
  if (replay != nullptr) return Replay(*replay, frame);
  if (scenario.plan.replay) return Replay(ReadTrajectory(*scenario.plan.replay), frame);
  FlightPlan plan = PlanFlight(scenario.plan);
  const auto dryden = Dryden(scenario, plan.mean_speed_mps);
  Disturbance disturbance =
      MakeDisturbance(scenario.plan.turbulence, plan.mean_speed_mps, scenario.plan.stabilised_mount,
                      seed, dryden ? &*dryden : nullptr);
  return {std::move(plan), scenario.start_s, std::move(disturbance), dryden};
}

/// Returns null without vibration and fast turbulence.
std::shared_ptr<const PlatformVibration> MakeVibration(
    const PlanScenario& plan, const std::optional<DrydenTurbulence>& dryden, std::uint64_t seed) {
  PlatformVibration vibration(plan.vibration, seed);
  if (dryden) vibration.AddTurbulence(*dryden, plan.stabilised_mount, seed);
  if (vibration.empty()) return nullptr;
  return std::make_shared<const PlatformVibration>(std::move(vibration));
}

/// Returns the time at which the flight reaches the planned time path_s; turbulence makes it lead
/// or lag. The time is never before the beginning of the flight.
double FlownTime(const Disturbance& disturbance, double path_s) {
  double t_s = path_s;
  // This fixed-point iteration is a contraction.
  for (int i = 0; i < 50; ++i) t_s = path_s - disturbance.lead_s.At(t_s).value;
  return std::max(0.0, t_s);
}

/// Returns the strips that the scenario gives; throws InvalidConfig if one lies outside the flight.
std::vector<StripInterval> NamedStrips(const PlanScenario& plan, const FlownPlan& flown) {
  const double end_s = flown.begin_s + flown.plan.duration_s;
  for (const StripInterval& strip : plan.strips) {
    if (strip.t0_s >= flown.begin_s && strip.t1_s <= end_s) continue;
    throw InvalidConfig("strip '" + strip.name + "' lies outside the time of the flight, " +
                            FormatDouble(flown.begin_s) + " to " + FormatDouble(end_s) + " s",
                        plan.where);
  }
  return plan.strips;
}

std::vector<StripInterval> Strips(const PlanScenario& plan, const FlownPlan& flown) {
  if (!plan.strips.empty()) return NamedStrips(plan, flown);
  std::vector<StripInterval> strips;
  for (const Vector2d& strip_s : flown.plan.strips_s) {
    strips.push_back({std::to_string(strips.size() + 1),
                      flown.begin_s + FlownTime(flown.disturbance, strip_s.x()),
                      flown.begin_s + FlownTime(flown.disturbance, strip_s.y())});
  }
  return strips;
}

void CheckClearance(const Scenario& scenario, const std::vector<StripInterval>& strips,
                    const TruthTrajectory& truth, const Terrain& terrain) {
  for (const StripInterval& strip : strips) {
    for (double t_s = strip.t0_s; t_s <= strip.t1_s; t_s += 1.0) {
      const Vector3d p_m = truth.Pose(t_s).p_mb;
      const double above_m = p_m.z() - terrain.Surface(p_m.head<2>()) - terrain.tallest_plant_m();
      if (above_m < kLowestFlight_m) {
        throw InvalidConfig("line " + strip.name + " of scenario '" + scenario.name + "' passes " +
                                FormatDouble(std::round(above_m)) +
                                " m above the terrain; raise it to at least 10 m, or lower "
                                "terrain.base_m",
                            scenario.plan.where);
      }
    }
  }
}

double Duration(const std::vector<StripInterval>& strips) {
  double sum_s = 0.0;
  for (const StripInterval& strip : strips) sum_s += strip.t1_s - strip.t0_s;
  return sum_s;
}

/// Returns the contents of flight.yaml: the assumed model without any true values.
FlightConfig AssumedConfig(const Scenario& scenario, const std::vector<StripInterval>& strips) {
  FlightConfig config;
  config.name = scenario.name;
  config.origin = scenario.origin;
  config.strips = strips;
  config.imu.emplace();
  config.imu->grade = scenario.imu.preset;
  config.imu->model = scenario.imu.model;
  config.imu->read.sampling = scenario.imu.sampling;
  config.gnss.emplace();
  config.gnss->lever_arm_b_m = scenario.gnss.lever_arm_b_m;
  config.gnss->sigma_enu_m = scenario.gnss.sigma_enu_m;
  config.gnss->processes = scenario.gnss.processes;
  return config;
}

std::vector<std::string> FileNames(const PairData& pairs) {
  std::vector<std::string> names;
  for (const auto& file : pairs.files) names.push_back(file.generic_string());
  return names;
}

BeamConfig AssumedBeams(const BeamScenario& beams) {
  return {beams.angles_rad.size(), beams.angles_rad, beams.angle_sigma_rad, beams.range_sigma_m};
}

/// `pairs` are those of the scanner alone.
LidarConfig AssumedLidar(const Scenario& scenario, const std::optional<PairData>& pairs) {
  LidarConfig lidar;
  lidar.name = scenario.lidar.name;
  if (pairs) lidar.p2p = FileNames(*pairs);
  lidar.mounting = scenario.lidar.mounting;
  lidar.mounting.boresight_rad.setZero();
  lidar.scan_axis_s = scenario.lidar.scan_axis_s;
  lidar.nadir_axis_s = scenario.lidar.nadir_axis_s;
  lidar.gsd_m = scenario.lidar.gsd_m;
  lidar.sigma_p_m = scenario.pairs.sigma_p_m;
  if (scenario.lidar.beams.count() > 0) lidar.beams = AssumedBeams(scenario.lidar.beams);
  return lidar;
}

/// Returns the true trajectory with rotated attitude; nullopt if no effect rotates it.
std::optional<Trajectory> TurnedTrajectory(const ActiveEffects& effects,
                                           const Trajectory& reference) {
  if (effects.trajectory_turn.empty()) return std::nullopt;
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  for (const Eigen::Quaterniond& more : effects.trajectory_turn) turn = turn * more;
  std::vector<NavPoint> points = reference.points();
  for (NavPoint& point : points) point.q_nb = (point.q_nb * turn).normalized();
  TrajectoryNotes notes;
  notes.velocity_from_file = true;
  return Trajectory(std::move(points), notes);
}

}  // namespace

namespace {

/// Simulates the pairs of all scanners, and states the scanners in the assumed model.
class ScannerSimulator {
 public:
  ScannerSimulator(const std::vector<Scenario>& scanners, const std::vector<ActiveEffects>& effects,
                   const std::shared_ptr<const Terrain>& terrain, const PairSimulation& options,
                   SimulatedFlight* out)
      : scanners_(scanners), effects_(effects), terrain_(terrain), options_(options), out_(*out) {}

  void Run() {
    FlightConfig& config = out_.flight.config;
    for (std::size_t k = 0; k < scanners_.size(); ++k) {
      const std::optional<PairData> pairs = OwnPairs(k);
      const LidarConfig lidar = AssumedLidar(scanners_[k], pairs);
      if (k == 0) {
        config.lidar = lidar;
      } else {
        config.more_scanners.push_back(lidar);
      }
      if (pairs) Append(*pairs, k, k);
    }
    for (std::size_t i = 0; i < scanners_.size(); ++i) {
      for (std::size_t j = i + 1; j < scanners_.size(); ++j) AddBetween(i, j);
    }
    if (!config.lidar->name.empty()) AssignScanners(ScannerNames(config), &config);
  }

 private:
  std::optional<PairData> OwnPairs(std::size_t k) const {
    if (scanners_[k].pairs.count == 0) return std::nullopt;
    PairSimulation options = options_;
    const std::string& name = scanners_[k].lidar.name;
    if (!name.empty()) options.folder = "lidar_" + name;
    return SimulatePairs(scanners_[k], out_.strips, out_.truth, terrain_, options, effects_[k]);
  }

  void AddBetween(std::size_t i, std::size_t j) {
    if (scanners_[i].pairs.between == 0) return;
    PairSimulation options = options_;
    options.folder = "lidar_" + scanners_[i].lidar.name + "_" + scanners_[j].lidar.name;
    const PairData pairs =
        SimulatePairsBetween({scanners_[i], effects_[i]}, {scanners_[j], effects_[j]}, out_.strips,
                             out_.truth, terrain_, options);
    const double sigma_p_m =
        std::hypot(scanners_[i].pairs.sigma_p_m, scanners_[j].pairs.sigma_p_m) / std::sqrt(2.0);
    out_.flight.config.pairs_between.push_back({i, j, FileNames(pairs), sigma_p_m});
    Append(pairs, i, j);
  }

  /// Appends pairs as ReadFlight does.
  void Append(PairData data, std::size_t i, std::size_t j) {
    if (!out_.flight.pairs) out_.flight.pairs.emplace();
    PairData& all = *out_.flight.pairs;
    for (LidarPair& pair : data.pairs) {
      pair.file += static_cast<int>(all.files.size());
      pair.scanner_i = static_cast<int>(i);
      pair.scanner_j = static_cast<int>(j);
      if (i + j == 0 || pair.covariance_m2) continue;
      const double sigma_m = PairSigma(out_.flight.config, pair);
      pair.covariance_m2 = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
    }
    all.files.insert(all.files.end(), data.files.begin(), data.files.end());
    all.pairs.insert(all.pairs.end(), data.pairs.begin(), data.pairs.end());
  }

  const std::vector<Scenario>& scanners_;
  const std::vector<ActiveEffects>& effects_;
  std::shared_ptr<const Terrain> terrain_;
  const PairSimulation& options_;
  SimulatedFlight& out_;
};

}  // namespace

FlightTimes PlannedTimes(const Scenario& scenario, std::uint64_t seed) {
  const FlownPlan flown = Plan(scenario, LocalFrame(scenario.origin), seed, nullptr);
  return {flown.begin_s, flown.begin_s + flown.plan.duration_s, Strips(scenario.plan, flown)};
}

SimulatedFlight Simulate(const Scenario& given, const SimulateOptions& options) {
  const Scenario scenario = WithBeamErrors(given, options.seed);
  const auto progress = [&](const char* stage) {
    return [&options, stage](double fraction) {
      if (options.progress) options.progress(stage, fraction);
    };
  };
  SimulatedFlight out;
  out.scenario = scenario;
  out.seed = options.seed;
  out.frame = LocalFrame(scenario.origin);
  out.boresight_rad = scenario.lidar.mounting.boresight_rad;
  const std::vector<Scenario> scanners = ScannerScenarios(scenario);
  std::vector<ActiveEffects> of_scanners;
  for (const Scenario& one : scanners) {
    of_scanners.push_back(MakeActiveEffects(one, options.seed, options.noise));
    if (of_scanners.size() == 1) continue;
    out.more_boresights_rad.push_back(one.lidar.mounting.boresight_rad);
    out.more_lever_arms_b_m.push_back(one.lidar.mounting.lever_arm_b_m +
                                      of_scanners.back().lidar_lever_arm_b_m);
  }
  ActiveEffects& effects = of_scanners.front();
  out.gnss_lever_arm_b_m = scenario.gnss.lever_arm_b_m + effects.gnss_lever_arm_b_m;
  out.lidar_lever_arm_b_m = scenario.lidar.mounting.lever_arm_b_m + effects.lidar_lever_arm_b_m;

  progress("trajectory")(0.0);
  CheckLimits(scenario, [](const auto&, const auto&) { return FileLocation(); });
  const FlownPlan flown = Plan(scenario, out.frame, options.seed, options.replay);
  CheckSamples(scenario.imu, flown.plan.duration_s);
  out.truth =
      std::make_shared<TruthTrajectory>(out.frame, flown.plan.path, flown.disturbance,
                                        flown.begin_s, flown.begin_s + flown.plan.duration_s,
                                        MakeVibration(scenario.plan, flown.dryden, options.seed));
  for (ActiveEffects& one : of_scanners) AddOwnErrors(options.own, out.truth, &one);
  out.strips = Strips(scenario.plan, flown);
  if (scenario.strips) {
    for (const Scenario& one : scanners) CheckPulses(one.lidar, Duration(out.strips));
  }
  const auto terrain = std::make_shared<const Terrain>(scenario.terrain);
  CheckClearance(scenario, out.strips, *out.truth, *terrain);

  out.flight.frame = out.frame;
  out.flight.config = AssumedConfig(scenario, out.strips);
  progress("imu")(0.0);
  SimulatedImu imu =
      SimulateImu(scenario, *out.truth, {options.seed, options.noise, progress("imu")}, effects);
  out.gyro_bias_radps = std::move(imu.gyro_bias_radps);
  out.accel_bias_mps2 = std::move(imu.accel_bias_mps2);
  out.flight.imu = std::move(imu.data);
  out.imu_rows = std::move(imu.rows);
  TrajectoryNotes notes;
  notes.velocity_from_file = true;
  out.flight.reference = Trajectory(std::move(imu.reference), notes);
  out.flight.trajectory = TurnedTrajectory(effects, *out.flight.reference);
  progress("gnss")(0.0);
  out.flight.gnss = SimulateGnss(scenario.gnss, *out.truth, options.seed, options.noise, effects);
  const PairSimulation pair_options{options.seed, options.noise, progress("pairs")};
  ScannerSimulator(scanners, of_scanners, terrain, pair_options, &out).Run();
  const LidarSpan span =
      out.flight.pairs ? LidarEpochSpan(out.flight.pairs->pairs) : LidarEpochSpan(out.strips);
  if (!scenario.control.empty() && !out.strips.empty()) {
    out.flight.control = SimulateControl(scenario, out.strips, out.truth, terrain,
                                         {options.seed, options.noise, span}, effects);
  }
  if (scenario.strips && !out.strips.empty()) {
    const auto clouds = [&](std::size_t k) {
      return std::make_shared<const SimulatedClouds>(
          scanners[k], out.strips, out.truth, of_scanners[k], span, options.seed, options.noise);
    };
    out.clouds = clouds(0);
    for (std::size_t k = 1; k < scanners.size(); ++k) out.more_clouds.push_back(clouds(k));
  }
  if (!out.flight.pairs && !out.clouds) out.flight.config.lidar.reset();
  return out;
}

}  // namespace dn
