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
#include <dn/flight/flight.h>
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

/// Blocks of one trajectory node.
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

/// Starting values of the trajectory, of the biases and of the calibration.
struct InitialStates {
  std::vector<MapPose> nodes;  ///< one per node time
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
  std::optional<CalibrationState> calibration = {};  ///< absent: AssumedCalibration of the flight
};

class FlightNetwork;

/// A pair's factor of one's own, instead of MakePairFactor.
struct PairModel {
  /// Unknowns of its own: the factor's blocks are the nine of PointToPoint, then these.
  std::vector<BlockId> blocks;
  /// Called for every pair, and again whenever its increments are integrated anew. The factor must
  /// be a PointPairFactor, too.
  std::function<std::shared_ptr<const FactorBase>(const Flight&, const PairParts&)> make;
};

/// Options of a FlightNetwork.
struct FlightNetworkOptions {
  /// Longest interval over which a Gauss-Markov process is held, as a fraction of tau and in seconds.
  /// That of a GNSS error is shorter where its sigma exceeds the white one of the positions, so that
  /// what the error changes by within an interval stays far below the white noise; and never shorter
  /// than one epoch.
  double bias_interval_per_tau = 1.0 / 40.0;
  double bias_interval_max_s = 5.0;
  double position_floor_m = 1e-6;  ///< of one inertial increment, see PreintegrationNoise
  /// Called once, before the first pairs are added, to add unknowns to the network and say how the
  /// factor of a pair is made. Pairs then go without bridges, and without effects of `estimate`.
  std::function<PairModel(FlightNetwork&)> pair_model = {};
  int threads = 1;  ///< of the increments of inertial edges and pairs; no result depends on it
};

/// The network of one flight: what `dn smooth` and `dn calibrate` solve. `net` is an ordinary
/// Network: add blocks and factors of your own to it before solving, they are treated like every
/// other.
///
/// Block names: "q_mb/<k>", "p_mb/<k>", "v_m/<k>"; "gyro_bias/<process>/<k>", "accel_bias/...",
/// "gnss_error/..."; "boresight", "gnss_lever_arm", "lidar_lever_arm", "lidar_time_offset", and every other effect of
/// `estimate` by its name.
/// Factor groups: "inertial", "gnss position", "gnss velocity", "lidar p2p", "bias process",
/// "gnss error process", "prior".
class FlightNetwork {
 public:
  /// Builds the inertial, GNSS and bias part, with nodes at node_t_s. A GNSS epoch is attached to
  /// the node at its time under the starting calibration (GnssEpochTime); one without a node there
  /// is left out. The flight must outlive the network. Throws InvalidInput when the IMU data do not
  /// cover the nodes.
  FlightNetwork(const Flight& flight, const std::vector<double>& node_t_s,
                const InitialStates& initial, const FlightNetworkOptions& options = {});

  /// Adds one edge for every pair, attached to the node before each of its epochs. Call it with a
  /// trajectory that is good already: the noise of the partial increments is evaluated once. Throws
  /// InvalidInput where a PairModel makes no PointPairFactor, or effects of `estimate` act on pairs
  /// beside it.
  void AddPairs(const std::vector<LidarPair>& pairs);

  /// Integrates every increment anew at the present biases and calibration, and moves the gravity
  /// expansion to the present positions. A factor that was replaced from outside
  /// (Network::ReplaceFactor) is left as it is.
  void Relinearise();

  /// The largest change of a bias or an effect since the increments were integrated, in units of 30
  /// deg/h (gyro), 5 mg (accelerometer) and ten usual sizes (effects): a hundredth of it is far
  /// below the noise of any increment.
  double BiasChange() const;

  /// All calibration values at present.
  CalibrationState Calibration() const;

  /// Sum of the processes of an axis at t_s.
  Eigen::Vector3d GyroBias(double t_s) const;
  Eigen::Vector3d AccelBias(double t_s) const;

  /// Sum of the lasting errors of a GNSS position at t_s, local east, north, up, m.
  Eigen::Vector3d GnssErrorEnu(double t_s) const;

  MapPose NodePose(std::size_t k) const;

  /// The state at any time as a function of the node before it, at the present biases and
  /// calibration: to look at. A factor of it would hold the biases, see AddAt.
  struct StateBetween {
    std::size_t node = 0;      ///< its blocks are the factor's
    StateAfterNode state;      ///< from theirs
    Preintegrated increments;  ///< with the covariance that their white noise adds
  };
  /// Throws InvalidInput when t_s lies outside the nodes, or no inertial data lead to it.
  StateBetween StateAt(double t_s) const;

  /// Adds a factor on the state at any time, r = W f(state, own blocks):
  ///
  ///   flight.AddAt(t_s, [](const auto& state) { return state.v_m; }, dn::Noise<3>::Sigma(0.02));
  ///
  /// `function` takes a KinematicState<T>, then one `const auto&` per block of one's own, and
  /// returns R numbers as in Network::Add. The state follows the node before t_s and the biases
  /// that hold there: within one interval a tilt and an accelerometer bias undo each other, and
  /// both are unknown. The white noise of the increments from the node to t_s does not count beside
  /// `noise`. Throws as StateAt.
  template <class Function, int R, class... Own>
  FactorId AddAt(double t_s, Function function, const Noise<R>& noise, Block<Own>... own) {
    const StateBetween at = StateAt(t_s);
    std::vector<BlockId> blocks = StateBlocks(at.node);
    (blocks.push_back(own.id), ...);
    using F = StateFunctionFactor<Function, R, Own...>;
    return net.AddFactor(std::make_shared<F>(std::move(function), noise, at.state, at.increments,
                                             gyro_bias.size(), accel_bias.size()),
                         blocks);
  }

  /// The factor of an edge for another calibration, at the present trajectory and biases: with its
  /// blocks, then the effects of the calibration in the order of EffectsOf...
  struct InertialEdge;
  struct GnssEdge;
  struct PairEdge;
  std::shared_ptr<const PreintegratedInertial> InertialFactor(
      const InertialEdge& edge, const CalibrationState& calibration) const;
  /// The same about the increments in use, which stay as they are: the derivatives by the effects
  /// alone are integrated, over the samples of `imu` (MeansOver).
  std::shared_ptr<const PreintegratedInertial> InertialFactorByMeans(
      const InertialEdge& edge, const CalibrationState& calibration, const ImuData& imu) const;
  std::shared_ptr<const FactorBase> GnssPositionFactor(const GnssEdge& edge,
                                                       const CalibrationState& calibration) const;
  std::shared_ptr<const FactorBase> GnssVelocityFactor(const GnssEdge& edge,
                                                       const CalibrationState& calibration) const;

  /// An end of pair edge k.
  struct EndOfPair {
    std::size_t k = 0;
    PointPairFactor::End end = PointPairFactor::End::kI;
  };
  /// By how much the residual of the pair moves with what effects do to the point, at the present
  /// unknowns; where its factor does not say, as that of the library would.
  PointSensitivity SensitivityOfEnd(const EndOfPair& end) const;

  /// Calls use(end, increments) for all ends of pairs: from their node to their epoch for that
  /// calibration, without noise, over the samples of `imu` (MeansOver). Ends of different nodes come
  /// side by side.
  using UseOfEnd = std::function<void(const EndOfPair&, const Preintegrated&)>;
  void ForPairEnds(const CalibrationState& calibration, const ImuData& imu, int threads,
                   const UseOfEnd& use) const;

  /// The two points of pair edge k in m with the present unknowns: p_i - p_j, m. Throws
  /// InvalidInput where its factor was replaced by one that is no PointPairFactor.
  Eigen::Vector3d PairDifference(std::size_t k) const;

  /// Blocks of a PairModel at the end of every pair; 0 without one.
  std::size_t num_own_pair_blocks() const { return pair_model_ ? pair_model_->blocks.size() : 0; }

  const Flight& flight() const { return *flight_; }
  const std::vector<double>& node_times() const { return node_t_s_; }

  Network net;
  std::vector<NodeBlocks> nodes;
  std::vector<ProcessChain> gyro_bias;
  std::vector<ProcessChain> accel_bias;
  /// One per gnss.processes: east, north, up in units of the process's sigmas (see GnssError).
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
    FactorId velocity = -1;  ///< -1: none
  };
  struct PairEdge {
    LidarPair pair;
    std::size_t node_i = 0;
    std::size_t node_j = 0;
    /// Inertial edges over which the ends are bridged (NodeBridge); absent: the white noise of the
    /// increments to the epochs does not count beside the noise of the pair.
    std::optional<std::size_t> bridge_i = {};
    std::optional<std::size_t> bridge_j = {};
    FactorId id = -1;
  };
  std::vector<InertialEdge> inertial_edges;
  std::vector<GnssEdge> gnss_edges;
  std::vector<PairEdge> pair_edges;
  long pairs_within_one_node = 0;  ///< left out: both ends attach to the same node
  long pairs_in_imu_gaps = 0;      ///< left out: no inertial data lead to one of their epochs

 private:
  /// Node k's, then those of the biases that hold there.
  std::vector<BlockId> StateBlocks(std::size_t k) const;
  /// Of node k, without effects.
  ImuCorrection BiasesAt(std::size_t k) const;
  /// Of the blocks of pair edge k.
  std::vector<const double*> ValuesOfPair(std::size_t k) const;
  void AddMounting(const CalibrationState& calibration);
  void AddNodes(const InitialStates& initial);
  void AddBiases(const InitialStates& initial);
  void AddGnssErrors();
  double HoldingLength(const BiasProcess& process) const;
  void AddInertialEdges();
  void AddGnssEdges();
  bool Estimated(const std::string& unknown) const;
  void AddEffects(const CalibrationState& calibration);
  void AddPriors(const CalibrationState& assumed);
  void AppendEffects(const std::vector<std::size_t>& indices, std::vector<BlockId>* blocks) const;
  bool MovesLidarEpochs() const;
  PairEdge HangOnNodes(const LidarPair& pair, double margin_s) const;
  void Bridge(PairEdge* edge) const;
  std::vector<BlockId> PairBlocks(const PairEdge& edge) const;
  /// Of all inertial edges.
  std::vector<std::shared_ptr<const PreintegratedInertial>> InertialFactors(
      const CalibrationState& calibration) const;
  std::shared_ptr<const PreintegratedInertial> InertialFactorInUse(const InertialEdge& edge) const;
  std::shared_ptr<const PreintegratedInertial> InertialFactorOn(
      const Preintegrated& increments, const InertialEdge& edge,
      const CalibrationState& calibration) const;
  /// From their nodes to the epochs of both ends.
  struct PairIncrements {
    Preintegrated i, j;
  };
  /// Of some pair edges, at the present biases; the samples after a node are integrated once.
  std::vector<PairIncrements> IncrementsOf(std::span<const PairEdge> edges,
                                           const PairCalibration& calibration) const;
  PairEdgeInput InputOf(const PairEdge& edge, const PairIncrements& increments) const;
  /// As it is without a PairModel.
  std::shared_ptr<const FactorBase> PairFactor(const PairEdge& edge,
                                               const PairCalibration& calibration,
                                               const PairIncrements& increments) const;
  std::shared_ptr<const FactorBase> PairFactorOfModel(const PairEdge& edge,
                                                      const PairCalibration& calibration,
                                                      const PairIncrements& increments) const;
  /// Calls work(edge, make) for all pair edges, in their order; make(), called once at most, is the
  /// edge's factor. A PairModel is asked by one thread.
  template <class Work>
  void ForPairs(std::span<PairEdge> edges, const CalibrationState& calibration,
                const Work& work) const;
  void AskForPairModel();
  FactorId AddEdge(std::shared_ptr<const FactorBase> factor, const std::vector<BlockId>& blocks,
                   const FactorGroup& group, double t_s);
  template <class Make>
  void Renew(FactorId id, const Make& make);

  const Flight* flight_;
  std::vector<double> node_t_s_;
  FlightNetworkOptions options_;
  PreintegrationNoise noise_;
  std::vector<Eigen::Vector3d> linearised_gyro_bias_;  ///< per inertial edge
  std::vector<Eigen::Vector3d> linearised_accel_bias_;
  CalibrationState linearised_;
  std::optional<PairModel> pair_model_;
  std::map<FactorId, std::weak_ptr<const FactorBase>> made_;  // the factors of the edges
};

}  // namespace dn
