#include <dn/builder/build.h>
#include <dn/builder/flight_nodes.h>
#include <dn/error.h>
#include <dn/imu/implied_imu.h>

#include <string>

namespace dn {
namespace {

bool HasPairs(const Flight& flight) { return flight.pairs && !flight.pairs->pairs.empty(); }

MapGnss PlannedGnss(const LocalFrame& frame, const std::vector<MapPose>& poses,
                    const Eigen::Vector3d& lever_arm_b_m, double rate_hz) {
  if (!(rate_hz > 0.0)) {
    throw InvalidInput("plan: the GNSS rate is " + std::to_string(rate_hz) +
                       " Hz, must be greater than 0");
  }
  MapGnss gnss;
  const double t0_s = poses.front().t_s;
  for (double k = 1.0; t0_s + k / rate_hz < poses.back().t_s; ++k) {
    const MapPose pose = InterpolatePose(poses, t0_s + k / rate_hz);
    MapGnssEpoch epoch;
    epoch.t_s = pose.t_s;
    epoch.p_m = pose.p_mb + pose.q_mb * lever_arm_b_m;
    epoch.R_m_enu = frame.R_m_enu(epoch.p_m);
    gnss.epochs.push_back(epoch);
  }
  return gnss;
}

std::vector<double> DesignNodeTimes(const Flight& flight, const NetworkDesign& design) {
  if (!design.node_t_s.empty()) return design.node_t_s;
  if (!flight.gnss) {
    throw InvalidInput(
        "network design: the flight has no GNSS epochs that define the time span of the network; "
        "call PlanMeasurements first or set the node times");
  }
  return FlightNodeTimes(flight, NetworkSpan(flight, HasPairs(flight)), HasPairs(flight));
}

}  // namespace

FlightNetwork Build(const Flight& flight, const NetworkDesign& design,
                    const FlightNetworkOptions& options) {
  if (!flight.imu) {
    throw InvalidInput(
        "network design: the flight has no inertial data; for a plan, call PlanMeasurements first");
  }
  const std::vector<double> node_t_s = DesignNodeTimes(flight, design);
  InitialStates initial{{}, design.gyro_bias_radps, design.accel_bias_mps2, design.calibration};
  for (const double t_s : node_t_s) initial.nodes.push_back(InterpolatePose(design.poses, t_s));
  FlightNetwork network(flight, node_t_s, initial, options);
  if (HasPairs(flight)) network.AddPairs(flight.pairs->pairs);
  if (flight.control) network.AddControl(*flight.control);
  if (flight.ties) network.AddTies(*flight.ties);
  if (flight.surfaces) network.AddSurfaces(*flight.surfaces);
  return network;
}

void PlanMeasurements(const NetworkDesign& design, const PlannedRates& rates, Flight* flight) {
  if (!flight->imu) flight->imu = ImpliedImu(flight->frame, design.poses, rates.imu_hz);
  if (flight->gnss) return;
  const CalibrationState calibration = design.calibration.value_or(AssumedCalibration(*flight));
  flight->gnss =
      PlannedGnss(flight->frame, design.poses, calibration.gnss_lever_arm_b_m, rates.gnss_hz);
  if (flight->gnss->epochs.empty()) {
    throw InvalidInput(
        "plan: the poses are too short for a single GNSS epoch; give poses over a longer time");
  }
}

}  // namespace dn
