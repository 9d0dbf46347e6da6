#include <dn/adjustment/stages.h>
#include <dn/builder/flight_nodes.h>
#include <dn/builder/keep_in_use.h>
#include <dn/builder/node_grid.h>
#include <dn/imu/strapdown.h>
#include <dn/navigation/alignment.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "gnss_clock.h"
#include "network_at.h"

namespace dn {
namespace {

// Returns initial states at the nodes, from those of the forward filter on its coarser grid.
InitialStates StatesAtNodes(const Flight& flight, const std::vector<double>& node_t_s,
                            const std::vector<FilterState>& coarse) {
  std::vector<double> coarse_t_s;
  for (const FilterState& state : coarse) coarse_t_s.push_back(state.pose.t_s);
  InitialStates initial;
  MapPose last = coarse.front().pose;
  for (const double t_s : node_t_s) {
    const FilterState& before = coarse[NodeBefore(coarse_t_s, t_s + 1e-7)];
    const double reset_t_s = std::max(last.t_s, before.pose.t_s);
    if (before.pose.t_s >= last.t_s) last = before.pose;
    if (t_s - reset_t_s > 1e-7) {
      try {
        last = Propagate(flight.frame, last,
                         IntegrateMotion(*flight.imu, last.t_s, t_s,
                                         {before.TotalGyroBias(), before.TotalAccelBias()}));
      } catch (const InvalidInput&) {  // a gap in the inertial data: constant velocity
        last.p_mb += (t_s - last.t_s) * last.v_m;
      }
    } else if (t_s < last.t_s - 1e-7) {  // before the first GNSS epoch: constant velocity
      initial.nodes.push_back({t_s, last.q_mb, last.p_mb + (t_s - last.t_s) * last.v_m, last.v_m});
      continue;
    }
    last.t_s = t_s;
    initial.nodes.push_back(last);
  }
  initial.gyro_bias_radps = coarse.back().TotalGyroBias();
  initial.accel_bias_mps2 = coarse.back().TotalAccelBias();
  return initial;
}

std::vector<FilterState> NodeStates(const FlightNetwork& network) {
  std::vector<FilterState> states;
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    const double t_s = network.nodes()[k].t_s;
    states.push_back({network.trajectory().NodePose(k),
                      {network.trajectory().GyroBias(t_s)},
                      {network.trajectory().AccelBias(t_s)},
                      {},
                      {}});
  }
  return states;
}

}  // namespace

namespace adjustment_internal {

std::unique_ptr<FlightNetwork> RemakeNetwork(AdjustmentRun& run,
                                             const CalibrationState& calibration) {
  const Flight& flight = run.flight();
  const FlightNetwork& before = run.network();
  const bool with_pairs = run.options().with_pairs;
  const std::vector<double> node_t_s =
      FlightNodeTimes(flight, NetworkSpan(flight, with_pairs, calibration), with_pairs, calibration,
                      run.inertial());
  InitialStates initial = StatesAtNodes(flight, node_t_s, NodeStates(before));
  initial.calibration = calibration;
  auto network = std::make_unique<FlightNetwork>(flight, node_t_s, initial, run.network_options());
  for (const EffectBlock& effect : before.calibration().effects()) {
    network->net().Hold(network->net().Find(effect.name), before.net().block(effect.id).held);
  }
  return network;
}

void RemakeWholeNetwork(AdjustmentRun& run) {
  std::unique_ptr<FlightNetwork> network = RemakeNetwork(run, run.network().calibration().State());
  if (run.options().with_pairs) {
    const Flight& flight = run.flight();
    network->AddPairs(flight.pairs->pairs);
    if (flight.control) network->AddControl(*flight.control);
    if (flight.ties) network->AddTies(*flight.ties);
    if (flight.surfaces) network->AddSurfaces(*flight.surfaces);
  }
  KeepInUse(run.network(), network.get());
  run.result().network = std::move(network);
}

}  // namespace adjustment_internal

void MakeNetwork(AdjustmentRun& run) {
  run.Announce("alignment");
  const Flight& flight = run.flight();
  adjustment_internal::ExpectCommonTime(flight);
  const bool with_pairs = run.options().with_pairs;
  const TimeInterval gnss_span = NetworkSpan(flight, false);
  const std::vector<double> coarse =
      NodeTimes(*flight.imu, gnss_span, GnssTimes(flight, gnss_span), {}, {});
  const Alignment alignment = Align(flight, coarse, run.options().interrupted);
  const std::vector<double> node_t_s =
      FlightNodeTimes(flight, NetworkSpan(flight, with_pairs), with_pairs, {}, run.inertial());
  run.result().alignment_method = alignment.method;
  run.result().node_rate_hz = NodeRateHz(flight, with_pairs);
  run.result().network = std::make_unique<FlightNetwork>(
      flight, node_t_s, StatesAtNodes(flight, node_t_s, alignment.run.states),
      run.network_options());
}

void UseInertialRate(AdjustmentRun& run) {
  if (run.inertial() == run.flight().config.network.inertial) return;
  run.Announce("inertial rate");
  run.TakeRawInertial();
  adjustment_internal::RemakeWholeNetwork(run);
}

}  // namespace dn
