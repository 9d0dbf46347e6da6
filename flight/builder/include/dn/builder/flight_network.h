#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/builder/edge_factors.h>
#include <dn/builder/node_grid.h>
#include <dn/builder/process_chain.h>
#include <dn/builder/state_function_factor.h>
#include <dn/factors/point_sensitivity.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/factors/state_after_node.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/preintegration.h>
#include <dn/network.h>

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace dn {

/// The blocks of one trajectory node.
struct NodeBlocks {
  double t_s = 0.0;
  Block<Rotation> q_mb;
  Block<Vec<3>> p_mb;
  Block<Vec<3>> v_m;
};

/// An effect that is a block of the network.
struct EffectBlock {
  std::string name;
  EffectAction action;
  BlockId id = -1;
};

/// Initial values of the trajectory, of the biases and of the calibration.
struct InitialStates {
  std::vector<MapPose> nodes;  ///< one per node time
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
  std::optional<CalibrationState> calibration = {};  ///< absent: AssumedCalibration of the flight
};

class FlightNetwork;

/// A user-defined factor for point pairs that replaces MakePairFactor.
struct PairModel {
  /// Additional unknowns. The blocks of the factor are the nine blocks of PointToPoint, then these.
  std::vector<BlockId> blocks;
  /// Makes the factor of a pair. Called for every pair, and again whenever its increments are
  /// integrated again. The factor must also derive from PointPairFactor.
  std::function<std::shared_ptr<const FactorBase>(const Flight&, const PairParts&)> make;
};

/// The options of a FlightNetwork.
struct FlightNetworkOptions {
  /// Longest interval over which a Gauss-Markov process is constant, as a fraction of tau and in
  /// seconds. For a GNSS error whose sigma exceeds the white noise of the positions, the interval
  /// is shortened by the ratio of the variances. The change of the error within an interval then
  /// stays far below the white noise. An interval has at least one epoch.
  double bias_interval_per_tau = 1.0 / 40.0;
  double bias_interval_max_s = 5.0;
  double position_floor_m = 1e-6;  ///< added to each inertial increment, see PreintegrationNoise
  /// Called once, before the first pairs are added. It adds unknowns to the network and returns the
  /// way to make the factor of a pair. Pairs are then built without IncrementConditioning and
  /// without the effects of `estimate`.
  std::function<PairModel(FlightNetwork&)> pair_model = {};
  /// Threads for the preintegration of inertial edges and pairs; results do not depend on it.
  int threads = 1;
};

/// The network of one flight, which `dn smooth` and `dn calibrate` solve. `net` is an ordinary
/// Network: you can add your own blocks and factors before solving, and they are treated like all
/// others.
///
/// Block names: "q_mb/<k>", "p_mb/<k>", "v_m/<k>"; "gyro_bias/<process>/<k>", "accel_bias/...",
/// "gnss_error/..."; "boresight", "gnss_lever_arm", "lidar_lever_arm", "lidar_time_offset", and
/// every other effect of `estimate` by its name. Factor groups: "inertial", "gnss position", "gnss
/// velocity", "lidar p2p", "bias process", "gnss error process", "prior".
class FlightNetwork {
 public:
  /// Builds the inertial, GNSS and bias parts with nodes at node_t_s. A GNSS epoch is attached to
  /// the node at its time under the initial calibration (GnssEpochTime); an epoch without such a
  /// node is left out. The flight must outlive the network. Throws InvalidInput if the IMU data do
  /// not cover the nodes.
  FlightNetwork(const Flight& flight, const std::vector<double>& node_t_s,
                const InitialStates& initial, const FlightNetworkOptions& options = {});
  FlightNetwork(const Flight&& flight, const std::vector<double>& node_t_s,
                const InitialStates& initial, const FlightNetworkOptions& options = {}) = delete;

  /// Adds one factor per pair, attached to the node before each of its epochs. Call it with a
  /// trajectory that is already good, because the noise of the partial increments is evaluated only
  /// once. Throws InvalidInput if a PairModel returns a factor that is not a PointPairFactor, or if
  /// effects of `estimate` act on pairs that have a PairModel.
  void AddPairs(const std::vector<LidarPair>& pairs);

  /// Integrates all increments again at the present biases and calibration, and moves the expansion
  /// point of gravity to the present positions. Factors replaced by the caller
  /// (Network::ReplaceFactor) stay unchanged.
  void Repreintegrate();

  /// Returns the largest change of a bias or effect since the last preintegration. The units are 30
  /// deg/h (gyro), 5 mg (accelerometer) and ten typical sizes (effects). At a hundredth of such a
  /// unit, the error of the first-order correction is far below the noise of every increment.
  double BiasChange() const;

  /// Returns the present calibration values.
  CalibrationState Calibration() const;

  /// These two functions return the sum of the bias processes at t_s for each axis, rad/s and
  /// m/s^2.
  Eigen::Vector3d GyroBias(double t_s) const;
  Eigen::Vector3d AccelBias(double t_s) const;

  /// Returns the sum of the time-correlated errors of a GNSS position at t_s, local east, north,
  /// up, m.
  Eigen::Vector3d GnssErrorEnu(double t_s) const;

  MapPose NodePose(std::size_t k) const;

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
    const StateBetween at = StateAt(t_s);
    std::vector<BlockId> blocks = StateBlocks(at.node);
    (blocks.push_back(net.Id(own)), ...);
    using F = StateFunctionFactor<Function, R, Own...>;
    return net.AddFactor(std::make_shared<F>(std::move(function), noise, at.state, at.increments,
                                             gyro_bias.size(), accel_bias.size()),
                         blocks);
  }

  /// The functions below return the factor of an edge for another calibration at the present
  /// trajectory and biases. Its blocks are those of the edge, then the effects of the calibration
  /// in the order of InertialEffectIndices or GnssEffectIndices.
  struct InertialEdge;
  struct GnssEdge;
  struct PairEdge;
  std::shared_ptr<const PreintegratedInertial> InertialFactor(
      const InertialEdge& edge, const CalibrationState& calibration) const;
  /// Returns the factor of InertialFactor without integrating the increments again: they are those
  /// in use. Only their derivatives with respect to the effects are integrated, over the averaged
  /// samples `imu` (AverageSamples).
  std::shared_ptr<const PreintegratedInertial> InertialFactorByMeans(
      const InertialEdge& edge, const CalibrationState& calibration, const ImuData& imu) const;
  std::shared_ptr<const FactorBase> GnssPositionFactor(const GnssEdge& edge,
                                                       const CalibrationState& calibration) const;
  std::shared_ptr<const FactorBase> GnssVelocityFactor(const GnssEdge& edge,
                                                       const CalibrationState& calibration) const;

  /// One end of pair edge k.
  struct PairEndIndex {
    std::size_t k = 0;
    PointPairFactor::End end = PointPairFactor::End::kI;
  };
  /// Returns the sensitivity of the pair residual to a shift of the point of one end, at the
  /// present unknowns. If the factor of the pair does not provide it, the factor of the library is
  /// used instead.
  PointSensitivity EndSensitivity(const PairEndIndex& end) const;

  /// Calls use(end, increments) for all pair ends. The increments go from the node to the epoch of
  /// the end under the given calibration, without noise, over the averaged samples `imu`
  /// (AverageSamples). Ends of different nodes are visited in parallel, so that `use` must be
  /// thread-safe.
  using UsePairEnd = std::function<void(const PairEndIndex&, const Preintegrated&)>;
  void ForPairEnds(const CalibrationState& calibration, const ImuData& imu, int threads,
                   const UsePairEnd& use) const;

  /// Returns the difference p_i - p_j of the two points of pair edge k at the present unknowns, m,
  /// map axes. Throws InvalidInput if the factor was replaced by one that is not a PointPairFactor.
  Eigen::Vector3d PairDifference(std::size_t k) const;

  /// Returns the number of blocks that a PairModel appends to every pair; 0 without a PairModel.
  std::size_t num_own_pair_blocks() const { return pair_model_ ? pair_model_->blocks.size() : 0; }

  const Flight& flight() const { return *flight_; }
  const std::vector<double>& node_times() const { return node_t_s_; }

  Network net;
  std::vector<NodeBlocks> nodes;
  std::vector<ProcessChain> gyro_bias;
  std::vector<ProcessChain> accel_bias;
  /// One chain per entry of gnss.processes: east, north, up in units of the sigmas of the process
  /// (see CorrelatedGnssError).
  std::vector<ProcessChain> gnss_error;
  Block<LeftRotation> boresight;
  Block<Vec<3>> gnss_lever_arm;
  Block<Vec<3>> lidar_lever_arm;
  Block<Vec<1>> lidar_time_offset;
  std::vector<EffectBlock> effects;  ///< in the order of EstimableEffects

  struct InertialEdge {
    std::size_t node_i = 0;
    FactorId id = -1;
  };
  struct GnssEdge {
    std::size_t node = 0;
    std::size_t epoch = 0;  ///< index into flight().gnss->epochs
    FactorId position = -1;
    FactorId velocity = -1;  ///< -1: the velocity is not used
  };
  struct PairEdge {
    LidarPair pair;
    std::size_t node_i = 0;
    std::size_t node_j = 0;
    /// Indices of the inertial edges that condition the noise of the ends (IncrementConditioning).
    /// Absent: the white noise of the partial increments is negligible relative to the noise of the
    /// pair.
    std::optional<std::size_t> bridge_i = {};
    std::optional<std::size_t> bridge_j = {};
    FactorId id = -1;
  };
  std::vector<InertialEdge> inertial_edges;
  std::vector<GnssEdge> gnss_edges;
  std::vector<PairEdge> pair_edges;
  long pairs_within_one_node = 0;  ///< pairs left out because both ends attach to the same node
  /// Pairs left out because an IMU gap lies between an end and its node.
  long pairs_in_imu_gaps = 0;

 private:
  /// Returns the blocks of node k, then the bias blocks that apply there.
  std::vector<BlockId> StateBlocks(std::size_t k) const;
  /// Returns the biases at node k, without effects.
  ImuCorrection BiasesAt(std::size_t k) const;
  /// Returns pointers to the values of the blocks of pair edge k.
  std::vector<const double*> PairValues(std::size_t k) const;
  void AddMounting(const CalibrationState& calibration);
  void AddNodes(const InitialStates& initial);
  void AddBiases(const InitialStates& initial);
  void AddGnssErrors();
  double ConstantIntervalLength(const BiasProcess& process) const;
  void AddInertialEdges();
  void AddGnssEdges();
  bool Estimated(const std::string& unknown) const;
  void AddEffects(const CalibrationState& calibration);
  void AddPriors();
  void AppendEffects(const std::vector<std::size_t>& indices, std::vector<BlockId>* blocks) const;
  bool MovesLidarEpochs() const;
  PairEdge AttachToNodes(const LidarPair& pair, double margin_s) const;
  void Bridge(PairEdge* edge) const;
  std::vector<BlockId> PairBlocks(const PairEdge& edge) const;
  /// Returns the factors of all inertial edges for this calibration.
  std::vector<std::shared_ptr<const PreintegratedInertial>> InertialFactors(
      const CalibrationState& calibration) const;
  std::shared_ptr<const PreintegratedInertial> InertialFactorInUse(const InertialEdge& edge) const;
  std::shared_ptr<const PreintegratedInertial> InertialFactorOn(
      const Preintegrated& increments, const InertialEdge& edge,
      const CalibrationState& calibration) const;
  /// Increments from the nodes to the epochs of both ends of a pair.
  struct PairIncrements {
    Preintegrated i, j;
  };
  /// Integrates the increments of these pair edges at the present biases. Samples that several ends
  /// of a node share are integrated once.
  std::vector<PairIncrements> IntegratePairIncrements(std::span<const PairEdge> edges,
                                                      const PairCalibration& calibration) const;
  PairEdgeInput MakeEdgeInput(const PairEdge& edge, const PairIncrements& increments) const;
  /// Returns the factor of a pair as it is without a PairModel.
  std::shared_ptr<const FactorBase> PairFactor(const PairEdge& edge,
                                               const PairCalibration& calibration,
                                               const PairIncrements& increments) const;
  std::shared_ptr<const FactorBase> ModelPairFactor(const PairEdge& edge,
                                                    const PairCalibration& calibration,
                                                    const PairIncrements& increments) const;
  /// Calls work(edge, make) for all pair edges in their order. make() returns the factor of the
  /// edge and may be called once. A PairModel is called from one thread only.
  template <class Work>
  void ForPairs(std::span<PairEdge> edges, const CalibrationState& calibration,
                const Work& work) const;
  void RequestPairModel();
  FactorId AddEdge(std::shared_ptr<const FactorBase> factor, const std::vector<BlockId>& blocks,
                   const FactorGroup& group, double t_s);
  template <class Make>
  void Renew(FactorId id, const Make& make);

  const Flight* flight_;
  std::vector<double> node_t_s_;
  FlightNetworkOptions options_;
  PreintegrationNoise noise_;
  /// Biases at the last preintegration, one per inertial edge.
  std::vector<Eigen::Vector3d> linearised_gyro_bias_;
  std::vector<Eigen::Vector3d> linearised_accel_bias_;
  CalibrationState linearised_;
  std::optional<PairModel> pair_model_;
  // The factors that this class made for the edges.
  std::map<FactorId, std::weak_ptr<const FactorBase>> made_;
};

}  // namespace dn
