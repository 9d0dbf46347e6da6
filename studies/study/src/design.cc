#include <dn/adjustment/adjust.h>
#include <dn/adjustment/result.h>
#include <dn/builder/flight_nodes.h>
#include <dn/builder/node_grid.h>
#include <dn/error.h>
#include <dn/files/scanners.h>
#include <dn/rotation.h>
#include <dn/sim/no_overlap.h>
#include <dn/sim/simulate.h>
#include <dn/study/design.h>

#include <algorithm>
#include <utility>

namespace dn {
namespace {

// The rate is limited because a covariance depends on the density of the inertial noise, and hardly
// on the sampling rate. The motion on the strips is still resolved.
constexpr double kMostImuRateHz = 50.0;
constexpr double kPoseSpacingS = 0.05;  // for an INS/GNSS solution
constexpr std::size_t kFewestGnssEpochs = 3;

[[noreturn]] void FailWithoutPairs(const std::string& why) {
  throw RankDeficient(
      "the boresight is not observable: " + why +
      ". Fly at least two strips that overlap, preferably with one across the others");
}

void FreeUnknowns(const DesignOptions& options, Flight* flight) {
  if (options.estimate.empty()) return;
  FlightConfig& config = flight->config;
  config.estimate = ParseEstimate(options.estimate);
  if (NumScanners(config) > 1) AssignScanners(ScannerNames(config), &config);
}

void LimitNodeRate(double most_hz, Flight* flight) {
  if (NodeRateHz(*flight, true) > most_hz) flight->config.network.node_rate_hz = most_hz;
}

bool HasGnss(const Flight& flight) {
  return flight.gnss && flight.gnss->epochs.size() >= kFewestGnssEpochs;
}

/// Returns the nodes of the network. Without GNSS they cover all inertial data within the poses, if
/// any, so that messages can name the undetermined unknowns.
std::vector<double> ChooseNodes(const Flight& flight, const std::vector<MapPose>& poses) {
  if (HasGnss(flight)) return FlightNodeTimes(flight, NetworkSpan(flight, true), true);
  TimeInterval span{flight.imu->t_begin_s(), flight.imu->t_end_s()};
  if (!poses.empty()) {
    span.t0_s = std::max(span.t0_s, poses.front().t_s);
    span.t1_s = std::min(span.t1_s, poses.back().t_s);
  }
  return NodeTimes(*flight.imu, span, {}, {}, {});
}

Scenario WithPerfectSensors(Scenario scenario) {
  std::erase_if(scenario.effects, [](const Effect& effect) {
    return !IsEffect(effect.name, EffectId::kGnssOutage) &&
           !IsEffect(effect.name, EffectId::kImuGap);
  });
  scenario.imu.rate_hz = std::min(scenario.imu.rate_hz, kMostImuRateHz);
  return scenario;
}

SimulatedFlight Fly(const Scenario& scenario, const DesignOptions& options) {
  if (scenario.pairs.count == 0) FailWithoutPairs("the scenario has no pairs of points");
  SimulateOptions simulate;
  simulate.seed = options.seed;
  simulate.noise = false;
  simulate.progress = [&](const std::string&, double) {
    if (options.interrupted && options.interrupted()) throw Interrupted();
  };
  try {
    return Simulate(WithPerfectSensors(scenario), simulate);
  } catch (const NoOverlap& error) {
    FailWithoutPairs(error.what());
  }
}

std::vector<MapPose> SolveInsGnss(const Flight& flight, const DesignOptions& options,
                                  NetworkDesign* states) {
  AdjustOptions adjust;
  adjust.with_pairs = false;
  adjust.threads = options.threads;
  adjust.interrupted = options.interrupted;
  const Adjustment adjustment = Adjust(flight, adjust);
  const FlightNetwork& network = *adjustment.network;
  const double middle_s =
      0.5 * (network.trajectory().node_times().front() + network.trajectory().node_times().back());
  states->gyro_bias_radps = network.trajectory().GyroBias(middle_s);
  states->accel_bias_mps2 = network.trajectory().AccelBias(middle_s);
  std::vector<MapPose> poses;
  for (const NavPoint& point : DenseTrajectory(network, kPoseSpacingS)) {
    poses.push_back(ToMapPose(point, flight.frame));
  }
  return poses;
}

/// Returns whether a trajectory covers all data of the network.
bool CoversData(const std::optional<Trajectory>& trajectory, const Flight& flight) {
  if (!trajectory || trajectory->empty()) return false;
  if (!flight.imu || !HasGnss(flight)) return true;
  const TimeInterval span = NetworkSpan(flight, true);
  return trajectory->Covers(span.t0_s) && trajectory->Covers(span.t1_s);
}

void PlaceStates(const DesignOptions& options, StudyDesign* design) {
  const Flight& flight = design->flight;
  if (CoversData(flight.trajectory, flight)) {
    design->states.poses = flight.trajectory->ToMapPoses(flight.frame);
    design->source = DesignSource::kTrajectory;
  } else if (CoversData(flight.initial_guess, flight)) {
    design->states.poses = flight.initial_guess->ToMapPoses(flight.frame);
    design->source = DesignSource::kInitialGuess;
  } else if (flight.imu && HasGnss(flight)) {
    design->states.poses = SolveInsGnss(flight, options, &design->states);
    design->source = DesignSource::kInsGnss;
  } else {
    throw InvalidInput(
        "the states of the flight are unknown: it has neither a trajectory nor both inertial and "
        "GNSS data; add one of them, or study a scenario");
  }
}

/// Plans the measurements of a flight without inertial data, which has not been flown yet.
void PlanSensors(StudyDesign* design) {
  Flight& flight = design->flight;
  if (!flight.config.imu) {
    throw InvalidInput(
        "the flight has no section 'imu': its covariances depend on the noise of the inertial "
        "sensor");
  }
  if (flight.imu) return;
  const bool no_gnss = !flight.gnss && !flight.config.gnss;
  if (no_gnss) flight.gnss.emplace();
  PlanMeasurements(design->states, {}, &flight);
  if (no_gnss) flight.gnss.reset();
}

}  // namespace

std::vector<EstimateEntry> ParseEstimate(const std::string& list) {
  try {
    return ParseFlightConfig("name: study\nestimate: [boresight, " + list + "]\n", {}).estimate;
  } catch (const InvalidConfig& error) {
    throw InvalidConfig(std::string("estimate [") + list + "]: " + error.what());
  }
}

namespace {

void StateUnmodelled(const DesignOptions& options, Flight* flight) {
  if (options.unmodelled.empty()) return;
  try {
    flight->config.unmodelled =
        ParseFlightConfig("name: study\nunmodelled: " + options.unmodelled + "\n", {}).unmodelled;
  } catch (const InvalidConfig& error) {
    throw InvalidConfig("unmodelled " + options.unmodelled + ": " + error.what());
  }
}

}  // namespace

StudyDesign MakeDesign(const Scenario& scenario, const DesignOptions& options) {
  SimulatedFlight simulated = Fly(scenario, options);
  StudyDesign design;
  design.flight = std::move(simulated.flight);
  design.strips = std::move(simulated.strips);
  FreeUnknowns(options, &design.flight);
  StateUnmodelled(options, &design.flight);
  LimitNodeRate(options.max_node_rate_hz, &design.flight);
  CalibrationState calibration = AssumedCalibration(design.flight);
  calibration.q_boresight = Exp(simulated.boresight_rad);
  for (std::size_t k = 0; k < calibration.more_scanners.size(); ++k) {
    calibration.more_scanners[k].q_boresight = Exp(simulated.more_boresights_rad[k]);
  }
  design.states.calibration = std::move(calibration);
  design.states.node_t_s = ChooseNodes(design.flight, {});
  for (const double t_s : design.states.node_t_s) {
    design.states.poses.push_back(simulated.truth->Pose(t_s));
  }
  return design;
}

StudyDesign MakeDesign(Flight flight, const DesignOptions& options) {
  if (!flight.pairs || flight.pairs->pairs.empty()) {
    FailWithoutPairs("the flight has no pairs of points");
  }
  StudyDesign design;
  design.flight = std::move(flight);
  FreeUnknowns(options, &design.flight);
  StateUnmodelled(options, &design.flight);
  design.strips = FindStrips(design.flight);
  PlaceStates(options, &design);
  PlanSensors(&design);
  design.states.node_t_s = ChooseNodes(design.flight, design.states.poses);
  return design;
}

}  // namespace dn
