#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/builder/process_chain.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/preintegration.h>
#include <dn/network.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// The blocks of one trajectory node.
struct NodeBlocks {
  double t_s = 0.0;
  Block<Rotation> q_mb;
  Block<Vec<3>> p_mb;
  Block<Vec<3>> v_m;
};

/// Initial values of the trajectory, of the biases and of the calibration.
struct InitialStates {
  std::vector<MapPose> nodes;  ///< one per node time
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
  std::optional<CalibrationState> calibration = {};  ///< absent: AssumedCalibration of the flight
};

/// Largest distance in time at which a node counts as the node of an epoch, s.
inline constexpr double kOnNodeS = 2e-6;

/// Options of the process chains of a trajectory.
struct ChainOptions {
  /// Longest interval over which a Gauss-Markov process is constant, as a fraction of tau.
  double interval_per_tau = 0.0;
  double interval_max_s = 0.0;
  ProcessModel model = {};  ///< see FlightNetworkOptions::process_model
};

/// The states of a trajectory as blocks of a network: nodes, biases of the inertial sensors, and
/// time-correlated errors of the GNSS positions.
///
/// Block names: "q_mb/<k>", "p_mb/<k>", "v_m/<k>"; "gyro_bias/<process>/<k>", "accel_bias/...",
/// "gnss_error/...".
class TrajectoryGraph {
 public:
  /// Adds the blocks with their initial values, and the factors of the processes. The flight and
  /// the network must outlive the object. Throws InvalidInput if the numbers of poses and node
  /// times differ.
  TrajectoryGraph(const Flight& flight, const std::vector<double>& node_t_s,
                  const InitialStates& initial, const ChainOptions& options, Network* net);

  const std::vector<double>& node_times() const { return node_t_s_; }
  const std::vector<NodeBlocks>& nodes() const { return nodes_; }
  const std::vector<ProcessChain>& gyro_bias() const { return gyro_bias_; }
  const std::vector<ProcessChain>& accel_bias() const { return accel_bias_; }
  /// Returns one chain per entry of gnss.processes. The values are east, north, up in units of the
  /// sigmas of the process at the attitude of the epoch (see CorrelatedGnssError).
  const std::vector<ProcessChain>& gnss_error() const { return gnss_error_; }

  /// These two functions return the present pose of node k, and those of all nodes.
  MapPose NodePose(std::size_t k) const;
  std::vector<MapPose> NodePoses() const;

  /// These two functions return the sum of the bias processes at t_s for each axis, rad/s and
  /// m/s^2.
  Eigen::Vector3d GyroBias(double t_s) const;
  Eigen::Vector3d AccelBias(double t_s) const;

  /// Returns both biases at t_s, without effects.
  ImuCorrection BiasesAt(double t_s) const;

  /// Returns the sum of the time-correlated errors of a GNSS position at t_s, local east, north,
  /// up, m.
  Eigen::Vector3d GnssErrorEnu(double t_s) const;

  /// Returns the standard deviations that entry i of gnss.processes states for the attitude at t_s,
  /// local east, north, up, m.
  Eigen::Vector3d GnssErrorSigmaEnu(std::size_t i, double t_s) const;

  /// Returns the blocks of node k: attitude, position, velocity.
  std::vector<BlockId> NodeIds(std::size_t k) const;

  /// Returns the bias blocks that apply at node k, those of the gyros first.
  std::vector<BlockId> BiasIds(std::size_t k) const;

 private:
  void AddNodes(const std::vector<MapPose>& poses);
  void AddBiases(const InitialStates& initial, const ChainOptions& options);
  void AddGnssErrors(const ChainOptions& options);
  double ConstantIntervalLength(const BiasProcess& process, const ChainOptions& options) const;

  const Flight& flight_;
  Network& net_;
  std::vector<double> node_t_s_;
  std::vector<NodeBlocks> nodes_;
  std::vector<ProcessChain> gyro_bias_;
  std::vector<ProcessChain> accel_bias_;
  std::vector<ProcessChain> gnss_error_;
};

}  // namespace dn
