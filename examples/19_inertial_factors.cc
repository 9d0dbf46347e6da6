// An inertial and GNSS network from factors alone, without the network of a flight.
//
// Each GNSS epoch has a node with attitude, position and velocity; the biases of gyros and
// accelerometers are Gauss-Markov processes. The flight is simulated; headings start with an error
// of half a degree. Fails unless the errors of the nodes agree with their sigmas.
#include <dn/builder/process_chain.h>
#include <dn/builder/trajectory_graph.h>
#include <dn/factors/gnss_position.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/sim/simulate.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <cstdio>

int main() {
  const dn::Scenario scenario = dn::ReadScenario(
      "lar2", {"plan.warm_up_s=60", "imu.rate_hz=100", "pairs.count=100",
               "imu.gyro.processes=[{type: gauss_markov, sigma_deg_h: 2, tau_s: 200}]",
               "imu.accel.processes=[{type: gauss_markov, sigma_mg: 0.2, tau_s: 200}]"});
  const dn::SensorNoise &gyro = scenario.imu.model.gyro, &accel = scenario.imu.model.accel;
  const dn::SimulatedFlight sim = dn::Simulate(scenario, {});

  dn::Network net;
  const auto arm = net.AddVector<3>("lever arm", sim.gnss_lever_arm_b_m);
  net.Hold(arm);
  const Eigen::Vector3d zero(0, 0, 0), heading_error_rad(0, 0, 0.01);
  std::vector<double> t_s;
  for (const dn::MapGnssEpoch& epoch : sim.flight.gnss->epochs) t_s.push_back(epoch.t_s);
  const auto add_biases = [&](const char* name, const dn::SensorNoise& sensor) {
    return dn::AddProcessChain(sensor.processes[0], dn::IntervalsOverNodes(t_s, 1.0), {name}, zero,
                               &net);
  };
  const dn::ProcessChain gyro_bias = add_biases("gyro bias", gyro);
  const dn::ProcessChain accel_bias = add_biases("accelerometer bias", accel);

  std::vector<dn::NodeBlocks> nodes;
  for (const dn::MapGnssEpoch& epoch : sim.flight.gnss->epochs) {
    const dn::MapPose start = sim.truth->Pose(epoch.t_s);
    const std::string k = std::to_string(nodes.size());
    nodes.push_back({epoch.t_s, net.AddRotation("q" + k, start.q_mb * dn::Exp(heading_error_rad)),
                     net.AddVector<3>("p" + k, epoch.p_m), net.AddVector<3>("v" + k, start.v_m)});
    const dn::NodeBlocks& to = nodes.back();
    net.Add(dn::GnssPosition(epoch.p_m, dn::Noise<3>::Sigma(scenario.gnss.sigma_enu_m)), to.q_mb,
            to.p_mb, arm);
    if (nodes.size() == 1) continue;
    const dn::NodeBlocks& from = nodes[nodes.size() - 2];
    const dn::Preintegrated increments =
        dn::Preintegrate(*sim.flight.imu, from.t_s, to.t_s, {}, {gyro.white, accel.white});
    net.Add(dn::PreintegratedInertial(increments, sim.frame, net.Value(from.p_mb),
                                      net.Value(to.p_mb), 1, 1),
            from.q_mb, from.p_mb, from.v_m, to.q_mb, to.p_mb, to.v_m, gyro_bias.At(from.t_s),
            accel_bias.At(from.t_s));
  }

  const bool converged = dn::Solve(net).converged;
  dn::Marginals marginals(net);
  marginals.ComputeSelectedInverse();
  double sum2 = 0.0;
  for (const dn::NodeBlocks& node : nodes) {
    const dn::MapPose truth = sim.truth->Pose(node.t_s);
    const Eigen::Vector3d turn_rad = dn::Log(truth.q_mb.conjugate() * net.Value(node.q_mb));
    const Eigen::Vector3d error_m = net.Value(node.p_mb) - truth.p_mb;
    sum2 += turn_rad.cwiseQuotient(marginals.Sigma(node.q_mb)).squaredNorm() +
            error_m.cwiseQuotient(marginals.Sigma(node.p_mb)).squaredNorm();
  }
  const double rms = std::sqrt(sum2 / (6.0 * static_cast<double>(nodes.size())));
  std::printf("%zu nodes, rms of error / sigma %.2f\n", nodes.size(), rms);
  return converged && rms > 0.5 && rms < 1.5 ? 0 : 1;
}
