#pragma once

#include <dn/builder/calibration_blocks.h>
#include <dn/builder/control_edges.h>
#include <dn/builder/edge_context.h>
#include <dn/builder/gnss_edges.h>
#include <dn/builder/inertial_edges.h>
#include <dn/builder/pair_edges.h>
#include <dn/builder/state_function_factor.h>
#include <dn/builder/trajectory_graph.h>
#include <dn/factors/state_after_node.h>
#include <dn/files/flight.h>
#include <dn/imu/preintegration.h>
#include <dn/network.h>

#include <functional>
#include <memory>
#include <vector>

namespace dn {

class FlightNetwork;

/// The options of a FlightNetwork.
struct FlightNetworkOptions {
  /// Longest interval over which a Gauss-Markov process is constant, as a fraction of tau and in
  /// seconds. For a GNSS error whose sigma exceeds the white noise of the positions, the interval
  /// is shortened by the ratio of the variances. The change of the error within an interval then
  /// stays far below the white noise. An interval has at least one epoch.
  double bias_interval_per_tau = 1.0 / 40.0;
  double bias_interval_max_s = 5.0;
  /// Called for every error process of the inertial sensors and of GNSS, to give its chain another
  /// process; see ProcessModel. There is one chain per process of the configuration:
  /// "gyro_bias/0", "gyro_bias/1", "accel_bias/0", "gnss_error/0" and so on. The configured process
  /// still determines the intervals and the forward filter, so configure one with a similar sigma
  /// and time constant. To add a process, add such an entry to the configuration of the flight:
  ///
  ///   flight.config.imu->model.gyro.processes.push_back(
  ///       {dn::BiasProcess::Type::kGaussMarkov, sigma_radps, tau_s});
  ProcessModel process_model = {};
  double position_floor_m = 1e-6;  ///< added to each inertial increment, see PreintegrationNoise
  /// Called once, before the first pairs are added. It adds unknowns to the network and returns the
  /// way to make the factor of a pair. Pairs are then built without IncrementConditioning and
  /// without the effects of `estimate`.
  std::function<PairModel(FlightNetwork&)> pair_model = {};
  /// Threads for the preintegration of inertial edges and pairs; results do not depend on it.
  int threads = 1;
};

/// The network of one flight, which `dn smooth` and `dn calibrate` solve: a TrajectoryGraph,
/// CalibrationBlocks, and the edges of each sensor. net() is an ordinary Network: you can add your
/// own blocks and factors before solving, and they are treated like all others.
///
/// The block names are in CalibrationBlocks, TrajectoryGraph and ControlEdges. Factor groups:
/// "inertial", "gnss position", "gnss velocity", "lidar p2p", "bias process", "gnss error process",
/// "prior", and those of ControlEdges.
class FlightNetwork {
 public:
  /// Builds the inertial, GNSS and bias parts with nodes at node_t_s. The flight must outlive the
  /// network. Throws InvalidInput if the IMU data do not cover the nodes.
  FlightNetwork(const Flight& flight, const std::vector<double>& node_t_s,
                const InitialStates& initial, const FlightNetworkOptions& options = {});
  FlightNetwork(const Flight&& flight, const std::vector<double>& node_t_s,
                const InitialStates& initial, const FlightNetworkOptions& options = {}) = delete;

  /// Adds one factor per pair. Call it with a trajectory that is already good, because the noise of
  /// the partial increments is evaluated only once. Throws like PairEdges::SetModel and
  /// PairEdges::Add.
  void AddPairs(const std::vector<LidarPair>& pairs);

  /// Adds the control points and planes that have laser returns, which must outlive the network.
  /// Call it with a trajectory that is already good, as AddPairs.
  void AddControl(const ControlData& control) { parts_->control.Add(control); }

  /// Adds the tie points, which must outlive the network. Call it with a trajectory that is already
  /// good, as AddPairs. They do not change the other unknowns.
  void AddTies(const TieData& ties) { parts_->ties.Add(ties.points); }

  /// Adds the surface pairs, which must outlive the network: planes of unknown position with two
  /// returns each. Call it with a trajectory that is already good, as AddPairs.
  void AddSurfaces(const ControlData& surfaces) { parts_->surfaces.Add(surfaces); }

  /// Makes the factors of all edges again at the present biases and calibration. Factors replaced
  /// by the caller (Network::ReplaceFactor) stay unchanged.
  void Repreintegrate();

  /// The state at any time as a function of the node before it, at the present biases and
  /// calibration. Use it to inspect a state; a factor made from it would treat the biases as
  /// constants, so use AddAt for factors.
  struct StateBetween {
    std::size_t node = 0;      ///< node whose blocks a factor of this state has
    StateAfterNode state;      ///< computes the state from the blocks of the node
    Preintegrated increments;  ///< from the node to t_s, with the covariance of their white noise
  };
  /// Returns the state at t_s. Throws InvalidInput if t_s is outside the nodes, or the inertial
  /// data between the node and t_s are missing.
  StateBetween StateAt(double t_s) const;

  /// Adds a factor on the state at any time, r = W f(state, own blocks):
  ///
  ///   flight.AddAt(t_s, [](const auto& state) { return state.v_m; }, dn::Noise<3>::Sigma(0.02));
  ///
  /// `function` takes a KinematicState<T>, then one `const auto&` per additional block, and returns
  /// R numbers as in Network::Add. The state depends on the node before t_s and on the biases of
  /// that interval. The biases must be unknowns of the factor: within one interval a tilt and an
  /// accelerometer bias compensate each other. The white noise of the increments from the node to
  /// t_s is neglected relative to `noise`. Throws like StateAt.
  template <class Function, int R, class... Own>
  FactorId AddAt(double t_s, Function function, const Noise<R>& noise, Block<Own>... own) {
    using Check = CheckStateFunction<Function, Own...>;
    core_internal::ExpectFit<Check::Fit(), Check::template Size<R>(), R>();
    if constexpr (Check::template kGood<R>) {
      const StateBetween at = StateAt(t_s);
      std::vector<BlockId> blocks = trajectory().NodeIds(at.node);
      const std::vector<BlockId> biases = trajectory().BiasIds(at.node);
      blocks.insert(blocks.end(), biases.begin(), biases.end());
      (blocks.push_back(net().Id(own)), ...);
      using F = StateFunctionFactor<Function, R, Own...>;
      return net().AddFactor(
          std::make_shared<F>(std::move(function), noise, at.state, at.increments,
                              trajectory().gyro_bias().size(), trajectory().accel_bias().size()),
          blocks);
    }
    return -1;
  }

  /// The handles of the parts are valid for net() and for copies of it.
  Network& net() { return parts_->net; }
  const Network& net() const { return parts_->net; }

  const Flight& flight() const { return parts_->context.flight; }
  const CalibrationBlocks& calibration() const { return parts_->calibration; }
  const TrajectoryGraph& trajectory() const { return parts_->trajectory; }
  /// Returns the blocks of the nodes of trajectory().
  const std::vector<NodeBlocks>& nodes() const { return trajectory().nodes(); }
  const InertialEdges& inertial() const { return parts_->inertial; }
  const GnssEdges& gnss() const { return parts_->gnss; }
  const PairEdges& pairs() const { return parts_->pairs; }
  const ControlEdges& control() const { return parts_->control; }
  const ControlEdges& ties() const { return parts_->ties; }
  const ControlEdges& surfaces() const { return parts_->surfaces; }

 private:
  /// The parts refer to each other, so that they must not move.
  struct Parts {
    Parts(const Flight& flight, const std::vector<double>& node_t_s, const InitialStates& initial,
          const FlightNetworkOptions& options);

    Network net;
    CalibrationBlocks calibration;
    TrajectoryGraph trajectory;
    MadeFactors factors;
    EdgeContext context;
    InertialEdges inertial;
    GnssEdges gnss;
    PairEdges pairs;
    ControlEdges control, ties, surfaces;
  };

  std::function<PairModel(FlightNetwork&)> make_pair_model_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace dn
