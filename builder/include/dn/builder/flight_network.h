#pragma once

#include <dn/builder/node_grid.h>
#include <dn/factors/gnss_velocity.h>
#include <dn/flight/flight.h>
#include <dn/geo/trajectory.h>
#include <dn/imu/preintegration.h>
#include <dn/network.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

namespace dn {

/// Blocks of one trajectory node.
struct NodeBlocks {
  double t_s = 0.0;
  Block<Rotation> q_mb;
  Block<Vec<3>> p_mb;
  Block<Vec<3>> v_m;
};

/// One bias process of one sensor triad as blocks: a single one for a random constant, else one per
/// interval (the bias is held over an interval, whose value stands for the interval's middle).
struct BiasChain {
  BiasProcess process;
  std::vector<double> t_begin_s;  ///< start of each interval
  std::vector<double> t_mid_s;
  std::vector<Block<Vec<3>>> blocks;

  /// The block that holds at t_s.
  Block<Vec<3>> At(double t_s) const;
};

/// Starting values of the trajectory and of the biases.
struct InitialStates {
  std::vector<MapPose> nodes;  ///< one per node time
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias_mps2 = Eigen::Vector3d::Zero();
};

struct FlightNetworkOptions {
  /// Longest interval over which a Gauss-Markov bias is held, as a fraction of tau and in seconds.
  double bias_interval_per_tau = 1.0 / 40.0;
  double bias_interval_max_s = 5.0;
  double position_floor_m = 1e-6;  ///< of one inertial increment, see PreintegrationNoise
};

/// The network of one flight: what `dn smooth` and `dn calibrate` solve. `net` is an ordinary
/// Network: add blocks and factors of your own to it before solving, they are treated like every
/// other.
///
/// Block names: "q_mb/<k>", "p_mb/<k>", "v_m/<k>"; "gyro_bias/<process>/<k>", "accel_bias/...";
/// "boresight", "gnss_lever_arm", "lidar_lever_arm", "lidar_time_offset", "gyro_scale_factor".
/// Factor groups: "inertial", "gnss position", "gnss velocity", "lidar p2p", "bias process",
/// "prior".
class FlightNetwork {
 public:
  /// Builds the inertial, GNSS and bias part, with nodes at node_t_s. The flight must outlive the
  /// network. Throws InvalidInput when the IMU data do not cover the nodes.
  FlightNetwork(const Flight& flight, const std::vector<double>& node_t_s,
                const InitialStates& initial, const FlightNetworkOptions& options = {});

  /// Adds one edge for every pair, attached to the node before each of its epochs. Call it with a
  /// trajectory that is good already: the noise of the partial increments is evaluated once.
  void AddPairs(const std::vector<LidarPair>& pairs);

  /// Integrates every increment anew at the present biases (and time offset, and gyro scale), and
  /// moves the gravity expansion to the present positions.
  void Relinearise();

  /// The largest change of a bias since the increments were integrated, in units of 30 deg/h (gyro)
  /// and 5 mg (accelerometer): a hundredth of it is far below the noise of any increment.
  double BiasChange() const;

  /// Sum of the processes of an axis at t_s.
  Eigen::Vector3d GyroBias(double t_s) const;
  Eigen::Vector3d AccelBias(double t_s) const;

  MapPose NodePose(std::size_t k) const;

  /// The two points of pair edge k in m with the present unknowns: p_i - p_j, m.
  Eigen::Vector3d PairDifference(std::size_t k) const;

  const Flight& flight() const { return *flight_; }
  const std::vector<double>& node_times() const { return node_t_s_; }

  Network net;
  std::vector<NodeBlocks> nodes;
  std::vector<BiasChain> gyro_bias;
  std::vector<BiasChain> accel_bias;
  Block<LeftRotation> boresight;
  Block<Vec<3>> gnss_lever_arm;
  Block<Vec<3>> lidar_lever_arm;
  Block<Vec<1>> lidar_time_offset;
  Block<Vec<3>> gyro_scale_factor;

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
    FactorId id = -1;
  };
  std::vector<InertialEdge> inertial_edges;
  std::vector<GnssEdge> gnss_edges;
  std::vector<PairEdge> pair_edges;
  long pairs_within_one_node = 0;  ///< left out: both ends attach to the same node
  long pairs_in_imu_gaps = 0;      ///< left out: no inertial data lead to one of their epochs

 private:
  void AddMounting();
  void AddNodes(const InitialStates& initial);
  void AddBiases(const InitialStates& initial);
  void AddBiasChain(const BiasProcess& process, const std::string& name, bool gyro,
                    const Eigen::Vector3d& start, std::vector<BiasChain>* chains);
  void AddInertialEdges();
  void AddGnssEdges();
  bool Estimated(const std::string& unknown) const;
  void AddPriorOf(const std::string& unknown);

  ImuCorrection CorrectionAt(double t_s) const;
  std::shared_ptr<const FactorBase> MakeInertialFactor(std::size_t i) const;
  std::shared_ptr<const FactorBase> MakeVelocityFactor(const GnssEdge& edge) const;
  std::shared_ptr<const FactorBase> MakePairFactor(const PairEdge& edge) const;
  bool gyro_scale_free() const { return gyro_scale_factor.id >= 0; }

  const Flight* flight_;
  std::vector<double> node_t_s_;
  FlightNetworkOptions options_;
  PreintegrationNoise noise_;
  std::vector<Eigen::Vector3d> linearised_gyro_bias_;  ///< per inertial edge
  std::vector<Eigen::Vector3d> linearised_accel_bias_;
};

/// Noise of a GNSS epoch's position in the mapping frame: the file's covariance or the flight's
/// default, scaled, rotated from the ENU of the point.
Eigen::Matrix3d GnssPositionCovariance(const GnssEpoch& epoch, const GnssConfig& config,
                                       const LocalFrame& frame);

/// Velocity edge of a GNSS epoch that has one: covariance scaled and rotated as for the position.
/// w_ib_b_radps: bias-corrected angular rate at the epoch, for the lever arm; added_covariance in
/// (m/s)^2.
GnssVelocity MakeGnssVelocity(const GnssEpoch& epoch, const GnssConfig& config,
                              const LocalFrame& frame, const Eigen::Vector3d& w_ib_b_radps,
                              const Eigen::Matrix3d& added_covariance = Eigen::Matrix3d::Zero());

/// Whether the velocity of an epoch is used: by the configuration, else when it is there with its
/// sigma.
bool UsesVelocity(const GnssEpoch& epoch, const GnssConfig& config);

}  // namespace dn
