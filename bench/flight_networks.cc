#include "flight_networks.h"

#include <dn/adjustment/adjust.h>
#include <dn/builder/node_grid.h>
#include <dn/navigation/alignment.h>
#include <dn/rotation.h>
#include <dn/sim/scenario.h>

#include <vector>

#include "flight_sizes.h"

namespace dn::bench {
namespace {

constexpr double kStripJoin_s = 5.0;

std::vector<TimeInterval> LidarIntervals(const Flight& flight) {
  std::vector<double> t_s;
  for (const LidarPair& pair : flight.pairs->pairs) {
    t_s.push_back(pair.t_i_s);
    t_s.push_back(pair.t_j_s);
  }
  return ClusterEpochs(t_s, kStripJoin_s);
}

std::unique_ptr<FlightNetwork> NetworkAtTruth(const SimulatedFlight& simulated, double rate_hz) {
  const Flight& flight = simulated.flight;
  const TimeInterval span = NetworkSpan(flight, true);
  NodeGridOptions grid;
  grid.rate_in_strips_hz = rate_hz;
  const std::vector<double> node_t_s =
      NodeTimes(*flight.imu, span, GnssTimes(flight, span), LidarIntervals(flight), grid);
  InitialStates initial;
  for (const double t_s : node_t_s) initial.nodes.push_back(simulated.truth->Pose(t_s));
  auto network = std::make_unique<FlightNetwork>(flight, node_t_s, initial);
  network->net().SetValue(network->calibration().boresight(), Exp(simulated.boresight_rad));
  network->AddPairs(flight.pairs->pairs);
  return network;
}

}  // namespace

std::unique_ptr<FlightAtTruth> MakeFlightAtTruth(const std::string& size, double rate_hz) {
  const Scenario scenario = ParseScenario(ScenarioText(SizeByName(size), "airins"), size);
  auto flight = std::make_unique<FlightAtTruth>(FlightAtTruth{Simulate(scenario, {}), nullptr});
  flight->network = NetworkAtTruth(flight->simulated, rate_hz);
  return flight;
}

}  // namespace dn::bench
