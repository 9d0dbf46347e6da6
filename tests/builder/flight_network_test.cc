#include <dn/builder/flight_network.h>
#include <dn/builder/gnss_factors.h>
#include <dn/builder/node_grid.h>
#include <dn/error.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/prior.h>
#include <dn/imu/imu_means.h>
#include <dn/navigation/alignment.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <map>
#include <set>
#include <type_traits>
#include <utility>

#include "builder/drone_flight.h"
#include "testing/expect_invalid.h"
#include "testing/short_flights.h"

namespace dn::builder_test {

using testing::Calibration;
using testing::DroneFlight;
using testing::DroneScenario;
using ::testing::HasSubstr;

/// Returns a network of the drone flight with the truth as initial values.
FlightNetwork AtTruth(const Flight& flight, const FlightNetworkOptions& options = {}) {
  const TimeInterval span = NetworkSpan(flight, true);
  const std::vector<double> times = NodeTimes(*flight.imu, span, GnssTimes(flight, span), {}, {});
  InitialStates initial;
  for (const double t_s : times) initial.nodes.push_back(DroneFlight().truth->Pose(t_s));
  return FlightNetwork(flight, times, initial, options);
}

std::map<std::string, long> GroupCounts(const Network& net) {
  std::map<std::string, long> counts;
  for (FactorId id = 0; id < net.num_factors(); ++id) {
    ++counts[net.group(id).name];
  }
  return counts;
}

TEST(FlightNetwork, BlocksHaveTheirNames) {
  const FlightNetwork network = AtTruth(DroneFlight().flight);
  const std::string last = std::to_string(network.nodes().size() - 1);
  EXPECT_EQ(network.net().Find("q_mb/0"), network.nodes().front().q_mb.id);
  EXPECT_EQ(network.net().Find("p_mb/" + last), network.nodes().back().p_mb.id);
  EXPECT_EQ(network.net().Find("v_m/" + last), network.nodes().back().v_m.id);
  EXPECT_EQ(network.net().Find("gyro_bias/0/0"), network.trajectory().gyro_bias()[0].blocks[0].id);
  EXPECT_EQ(network.net().Find("accel_bias/1/2"),
            network.trajectory().accel_bias()[1].blocks[2].id);
  for (const char* name : {"boresight", "gnss_lever_arm", "lidar_lever_arm", "lidar_time_offset"}) {
    EXPECT_GE(network.net().Find(name), 0);
  }
  EXPECT_THROW(network.net().Find("gyro_scale_factor"), InvalidInput);
}

TEST(FlightNetwork, GroupsHaveTheirCounts) {
  FlightNetwork network = AtTruth(DroneFlight().flight);
  network.AddPairs(DroneFlight().flight.pairs->pairs);
  auto counts = GroupCounts(network.net());
  const long nodes = static_cast<long>(network.nodes().size());
  const long chain = static_cast<long>(network.trajectory().gyro_bias()[1].blocks.size());
  EXPECT_EQ(counts["inertial"], nodes - 1);
  EXPECT_EQ(counts["gnss position"], static_cast<long>(network.gnss().edges().size()));
  EXPECT_EQ(counts["gnss position"],
            static_cast<long>(GnssTimes(DroneFlight().flight, {-1e300, 1e300}).size()) -
                static_cast<long>(DroneFlight().flight.gnss->epochs.back().t_s >
                                  DroneFlight().flight.imu->t_end_s() - 1e-6) -
                static_cast<long>(DroneFlight().flight.gnss->epochs.front().t_s <
                                  DroneFlight().flight.imu->t_begin_s() + 1e-6));
  EXPECT_EQ(counts["gnss velocity"], 0);
  EXPECT_EQ(counts["lidar p2p"], 300);
  EXPECT_EQ(counts["prior"], 4) << "one per bias process";
  EXPECT_EQ(counts["bias process"], 2 * (chain - 1));
  EXPECT_EQ(counts[""], 0) << "every factor is in a group";
}

// GNSS has 2 Hz. For tau = 120 s the error is constant over 3 s if its sigma equals the white
// noise. If it is three times as large, the interval is a ninth of that, which is less than one
// epoch.
TEST(FlightNetwork, TimeCorrelatedGnssErrorsAreStatesOfTheEpochs) {
  Flight flight = DroneFlight().flight;
  flight.config.gnss->processes = {{{0.015, 0.0, 0.03}, 120.0}, {{0.0, 0.0, 0.09}, 120.0}};
  FlightNetwork network = AtTruth(flight);
  ASSERT_EQ(network.trajectory().gnss_error().size(), 2U);
  EXPECT_EQ(network.trajectory().gnss_error()[1].blocks.size(), network.gnss().edges().size());
  EXPECT_NEAR(6.0 * static_cast<double>(network.trajectory().gnss_error()[0].blocks.size()),
              static_cast<double>(network.gnss().edges().size()), 6.0);
  EXPECT_EQ(network.net().Find("gnss_error/1/2"),
            network.trajectory().gnss_error()[1].blocks[2].id);
  auto counts = GroupCounts(network.net());
  EXPECT_EQ(counts["prior"], 4 + 2) << "one per process";
  EXPECT_EQ(counts["gnss error process"],
            static_cast<long>(network.trajectory().gnss_error()[0].blocks.size() +
                              network.trajectory().gnss_error()[1].blocks.size()) -
                2);
  const GnssEdge& edge = network.gnss().edges()[3];
  const double t_s = flight.gnss->epochs[edge.epoch].t_s;
  network.net().SetValue(network.trajectory().gnss_error()[0].At(t_s),
                         Eigen::Vector3d(2.0, 5.0, -1.0));
  network.net().SetValue(network.trajectory().gnss_error()[1].At(t_s),
                         Eigen::Vector3d(7.0, 5.0, 1.0));
  EXPECT_LE((network.trajectory().GnssErrorEnu(t_s) - Eigen::Vector3d(0.03, 0.0, 0.06)).norm(),
            1e-15);
}

/// Returns a network at the truth with one error by bank, which is at one sigma in all its states.
FlightNetwork WithErrorByBank(const Flight& flight) {
  FlightNetwork network = AtTruth(flight);
  for (const Block<Vec<3>>& block : network.trajectory().gnss_error()[0].blocks) {
    network.net().SetValue(block, Eigen::Vector3d::Ones());
  }
  return network;
}

Eigen::Vector3d PositionResidual(const FlightNetwork& network, const GnssEdge& edge) {
  const FactorRecord& record = network.net().factor(edge.position);
  std::vector<const double*> x;
  for (const BlockId block : record.blocks) x.push_back(network.net().block(block).value.get());
  Eigen::Vector3d r;
  EXPECT_TRUE(record.factor->Evaluate(x.data(), r.data(), nullptr));
  return r;
}

// The error enters the residuals in units of the white noise, in proportion to the true roll.
TEST(FlightNetwork, GnssErrorsByBankEnterTheResidualsInTurns) {
  Flight flight = DroneFlight().flight;
  const Eigen::Vector3d sigma_m(0.03, 0.06, 0.09), white_m(0.015, 0.015, 0.03);
  flight.config.gnss->processes = {{sigma_m, 10.0, GnssErrorGrowth::kBank}};
  const FlightNetwork without = AtTruth(DroneFlight().flight), with = WithErrorByBank(flight);
  double most_deg = 0.0;
  for (std::size_t e = 0; e < with.gnss().edges().size(); ++e) {
    const double t_s = flight.gnss->epochs[with.gnss().edges()[e].epoch].t_s;
    const double roll_rad = RollPitchHeading(DroneFlight().truth->Nav(t_s).q_nb).x();
    const double roll_deg = std::abs(roll_rad) / kRadPerDeg;
    most_deg = std::max(most_deg, roll_deg);
    const Eigen::Vector3d change = PositionResidual(with, with.gnss().edges()[e]) -
                                   PositionResidual(without, without.gnss().edges()[e]);
    const Eigen::Vector3d expected = roll_deg / 30.0 * sigma_m.cwiseQuotient(white_m);
    ASSERT_LE((change - expected).norm(), 2e-3) << "roll " << roll_deg << " deg";
    ASSERT_LE((with.trajectory().GnssErrorEnu(t_s) - roll_deg / 30.0 * sigma_m).norm(), 1e-6);
  }
  EXPECT_GT(most_deg, 20.0);
}

// The network neglects the derivative of the bank. A rotation of a milliradian moves a lever arm of
// a metre by a millimetre. It moves an error of three centimetres by a thirtieth of that.
TEST(FlightNetwork, GnssErrorsByBankFollowTheTrajectoryAtARebuild) {
  Flight flight = DroneFlight().flight;
  flight.config.gnss->processes = {{{0.03, 0.03, 0.03}, 10.0, GnssErrorGrowth::kBank}};
  FlightNetwork network = WithErrorByBank(flight);
  const GnssEdge edge = network.gnss().edges()[40];
  const double t_s = flight.gnss->epochs[edge.epoch].t_s;
  const auto roll = [&](double angle_rad) {
    const NodeBlocks& node = network.nodes()[edge.node];
    const Eigen::Quaterniond q_mb = network.net().Value(node.q_mb);
    network.net().SetValue(node.q_mb,
                           q_mb * Eigen::Quaterniond(Exp(Eigen::Vector3d(angle_rad, 0.0, 0.0))));
  };
  const Eigen::Vector3d before_m = network.trajectory().GnssErrorEnu(t_s);
  roll(1e-3);
  EXPECT_LT((network.trajectory().GnssErrorEnu(t_s) - before_m).norm(), 1.1e-4);
  roll(0.3);
  const Eigen::Vector3d stale = PositionResidual(network, edge);
  network.Repreintegrate();
  EXPECT_GT((PositionResidual(network, edge) - stale).norm(), 0.1);
}

TEST(FlightNetwork, BiasIntervalsCoverTheFlightAndKeepTheirLength) {
  FlightNetworkOptions options;
  options.bias_interval_per_tau = 0.01;  // 6 s for tau = 600 s
  Flight flight = DroneFlight().flight;
  flight.config.imu->model.gyro.processes.push_back({BiasProcess::Type::kRandomWalk, 1e-7, 0.0});
  const FlightNetwork network = AtTruth(flight, options);
  ASSERT_EQ(network.trajectory().gyro_bias().size(), 3U);
  EXPECT_EQ(network.trajectory().gyro_bias()[0].blocks.size(), 1U) << "a constant is one block";
  const std::vector<double> longest{6.0, 10.0};
  for (const std::size_t process : {1U, 2U}) {
    const ProcessChain& chain = network.trajectory().gyro_bias()[process];
    EXPECT_EQ(chain.t_begin_s.front(), network.trajectory().node_times().front());
    for (std::size_t k = 0; k < chain.blocks.size(); ++k) {
      const double end_s = k + 1 < chain.blocks.size() ? chain.t_begin_s[k + 1]
                                                       : network.trajectory().node_times().back();
      EXPECT_GT(end_s, chain.t_begin_s[k]);
      EXPECT_LE(end_s - chain.t_begin_s[k], longest[process - 1] + 1e-6);
      EXPECT_DOUBLE_EQ(chain.t_mid_s[k], 0.5 * (chain.t_begin_s[k] + end_s));
      EXPECT_EQ(chain.At(chain.t_begin_s[k]).id, chain.blocks[k].id);
      EXPECT_EQ(chain.At(end_s - 1e-3).id, chain.blocks[k].id);
    }
  }
}

TEST(FlightNetwork, StartingBiasGoesToTheFirstProcess) {
  const Flight& flight = DroneFlight().flight;
  const TimeInterval span = NetworkSpan(flight, true);
  InitialStates initial;
  const std::vector<double> times = NodeTimes(*flight.imu, span, {}, {}, {});
  for (const double t_s : times) initial.nodes.push_back(DroneFlight().truth->Pose(t_s));
  initial.gyro_bias_radps = {1e-4, -2e-4, 3e-4};
  initial.accel_bias_mps2 = {0.01, 0.02, -0.03};
  const FlightNetwork network(flight, times, initial);
  for (const double t_s : {times.front(), times.back()}) {
    EXPECT_EQ(network.trajectory().GyroBias(t_s), initial.gyro_bias_radps);
    EXPECT_EQ(network.trajectory().AccelBias(t_s), initial.accel_bias_mps2);
  }
  EXPECT_EQ(network.net().Value(network.trajectory().gyro_bias()[0].blocks[0]),
            initial.gyro_bias_radps);
}

TEST(FlightNetwork, ResidualsAtTheTruthOfANoiseFreeFlightVanish) {
  SimulateOptions options;
  options.noise = false;
  options.seed = 7;
  const SimulatedFlight sim = Simulate(DroneScenario(), options);
  FlightNetwork network = AtTruth(sim.flight);
  network.AddPairs(sim.flight.pairs->pairs);
  network.net().SetValue(network.calibration().boresight(), Exp(sim.boresight_rad));
  // Coning and sculling within a sample and the interpolation of the georeferencing are fractions
  // of a sigma.
  constexpr double kPerEdge = 1e-3;
  EXPECT_LT(EvaluateCost(network.net()).cost, kPerEdge * network.net().num_factors());
  EXPECT_LT(network.pairs().Difference(0).norm(), 1e-3);
}

TEST(FlightNetwork, UnknownsAreHeldUnlessEstimated) {
  Flight flight = DroneFlight().flight;
  flight.config.estimate = {{"gnss_lever_arm", {0.05}}, {"gyro_scale_factor", {500.0}}};
  const FlightNetwork network = AtTruth(flight);
  const auto held = [&](BlockId id) { return network.net().block(id).held; };
  EXPECT_TRUE(held(network.calibration().boresight().id));
  EXPECT_FALSE(held(network.calibration().gnss_lever_arm().id));
  EXPECT_TRUE(held(network.calibration().lidar_lever_arm().id));
  EXPECT_TRUE(held(network.calibration().lidar_time_offset().id));
  EXPECT_FALSE(held(network.net().Find("gyro_scale_factor")));
  EXPECT_EQ(GroupCounts(network.net())["prior"], 4 + 2);
  EXPECT_EQ(network.net().Value(network.calibration().gnss_lever_arm()),
            flight.config.gnss->lever_arm_b_m);
}

TEST(FlightNetwork, PriorsAreAtTheAssumedValuesWithTheirSigmas) {
  Flight flight = DroneFlight().flight;
  flight.config.estimate = {{"boresight", {}},
                            {"lidar_lever_arm", {0.02}},
                            {"lidar_time_offset", {0.001}},
                            {"gyro_scale_factor", {500.0}}};
  flight.config.lidar->boresight_sigma_rad = Eigen::Vector3d(0.01, 0.02, 0.03);
  FlightNetwork network = AtTruth(flight);
  network.net().SetValue(network.calibration().lidar_lever_arm(),
                         flight.config.lidar->mounting.lever_arm_b_m + Eigen::Vector3d(0.02, 0, 0));
  network.net().SetValue(network.calibration().lidar_time_offset(),
                         Eigen::Matrix<double, 1, 1>(0.003));
  const Block<Vec<3>> gyro_scale{network.net().Find("gyro_scale_factor")};
  network.net().SetValue(gyro_scale, Eigen::Vector3d(0.0, 2000e-6, 0.0));
  network.net().SetValue(network.calibration().boresight(), Exp(Eigen::Vector3d(0.0, 0.0, 0.15)));
  std::map<BlockId, double> norm;
  for (FactorId id = 0; id < network.net().num_factors(); ++id) {
    const FactorRecord& record = network.net().factor(id);
    Eigen::VectorXd r;
    if (record.blocks.size() != 1) continue;
    ASSERT_TRUE(network.net().EvaluateFactor(id, &r));
    norm[record.blocks[0]] = r.norm();
  }
  EXPECT_NEAR(norm[network.calibration().lidar_lever_arm().id], 1.0, 1e-9);
  EXPECT_NEAR(norm[network.calibration().lidar_time_offset().id], 3.0, 1e-9);
  EXPECT_NEAR(norm[gyro_scale.id], 4.0, 1e-9);
  EXPECT_NEAR(norm[network.calibration().boresight().id], 5.0, 1e-9);
}

TEST(FlightNetwork, NoInertialEdgeOverAGap) {
  Flight flight = DroneFlight().flight;
  const double t0_s = flight.gnss->epochs[50].t_s + 0.2;
  std::erase_if(flight.imu->samples, [&](const ImuSample& s) {
    return s.t_s > t0_s + 1e-6 && s.t_s < t0_s + 2.0 - 1e-6;
  });
  flight.imu->gaps.push_back({t0_s, t0_s + 1.99});
  const FlightNetwork network = AtTruth(flight);
  for (const auto& edge : network.inertial().edges()) {
    const double begin_s = network.trajectory().node_times()[edge.node_i];
    const double end_s = network.trajectory().node_times()[edge.node_i + 1];
    EXPECT_TRUE(end_s <= t0_s + 1e-6 || begin_s >= t0_s + 1.99 - 1e-6)
        << begin_s << " to " << end_s;
  }
  ASSERT_LT(network.inertial().edges().size(), network.nodes().size() - 1);
  const std::size_t at_gap = NodeNear(network.trajectory().node_times(), t0_s);
  EXPECT_FALSE(network.inertial().FindEdge(at_gap).has_value());
  EXPECT_EQ(network.inertial().FindEdge(at_gap - 1), at_gap - 1);
  EXPECT_EQ(network.inertial().FindEdge(at_gap + 1), at_gap);
}

// The parts refer to each other; a network that moves must not leave them behind.
TEST(FlightNetwork, PartsSurviveAMove) {
  static_assert(std::is_nothrow_move_constructible_v<FlightNetwork>);
  FlightNetwork first = AtTruth(DroneFlight().flight);
  first.AddPairs(DroneFlight().flight.pairs->pairs);
  FlightNetwork network = std::move(first);
  const auto before = network.net().factor(network.pairs().edges()[0].id).factor;
  const Eigen::Vector3d bias_radps(1e-4, 0.0, -2e-4);
  network.net().SetValue(network.trajectory().gyro_bias()[0].blocks[0], bias_radps);
  EXPECT_EQ(network.trajectory().GyroBias(network.nodes().front().t_s), bias_radps);
  EXPECT_GT(network.inertial().BiasChange(), 0.0);
  network.Repreintegrate();
  EXPECT_EQ(network.inertial().BiasChange(), 0.0);
  EXPECT_NE(network.net().factor(network.pairs().edges()[0].id).factor, before);
}

TEST(FlightNetwork, PairsWithinOneNodeAreCountedAndLeftOut) {
  FlightNetwork network = AtTruth(DroneFlight().flight);
  LidarPair pair = DroneFlight().flight.pairs->pairs.front();
  pair.t_j_s = pair.t_i_s;
  network.AddPairs({pair, DroneFlight().flight.pairs->pairs.front()});
  EXPECT_EQ(network.pairs().within_one_node(), 1);
  EXPECT_EQ(network.pairs().edges().size(), 1U);
}

/// Returns the whitening matrix of a pair, which is the derivative of its residual with respect to
/// the position of a node.
Eigen::Matrix3d Whitening(const FlightNetwork& network, const PairEdge& edge) {
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  EXPECT_TRUE(network.net().EvaluateFactor(edge.id, &r, &J));
  return J[1];
}

// White gyro noise turns the arm from the node to the epoch. Given the rotation at the next node,
// the variance over the three axes is 2 n^2 t (D - t) / D |u|^2.
TEST(FlightNetwork, PairsCarryTheNoiseOfTheIncrementBetweenTheirNodes) {
  FlightNetwork network = AtTruth(DroneFlight().flight);
  network.AddPairs(DroneFlight().flight.pairs->pairs);
  const double white = DroneFlight().flight.config.imu->model.gyro.white;
  const double sigma_p_m = DroneFlight().flight.config.lidar->sigma_p_m;
  constexpr double kTolerance = 0.1;  // allows for the lever arm and the white accelerometer noise
  for (const auto& edge : network.pairs().edges()) {
    ASSERT_TRUE(edge.bridge_i && edge.bridge_j);
    const auto variance = [&](std::size_t k, double t_s, const Eigen::Vector3d& u) {
      const double D =
          network.trajectory().node_times()[k + 1] - network.trajectory().node_times()[k];
      const double t = t_s - network.trajectory().node_times()[k];
      return 2.0 * white * white * t * (D - t) / D * u.squaredNorm();
    };
    const Eigen::Matrix3d W = Whitening(network, edge);
    const double excess = (W.transpose() * W).inverse().trace() - 3.0 * sigma_p_m * sigma_p_m;
    const double expected = variance(edge.node_i, edge.pair.t_i_s, edge.pair.u_i_s) +
                            variance(edge.node_j, edge.pair.t_j_s, edge.pair.u_j_s);
    EXPECT_NEAR(excess, expected, kTolerance * expected + 1e-9);
  }
}

TEST(FlightNetwork, NoBridgeWhereTheNoiseDoesNotCount) {
  Flight flight = DroneFlight().flight;
  flight.config.imu->model.gyro.white *= 1e-3;
  FlightNetwork network = AtTruth(flight);
  network.AddPairs(flight.pairs->pairs);
  for (const auto& edge : network.pairs().edges()) EXPECT_FALSE(edge.bridge_i || edge.bridge_j);
}

/// Returns pairs whose ends lie in node intervals without other pair ends.
std::vector<LidarPair> OnePerInterval(const Flight& flight, const std::vector<double>& node_t_s) {
  std::set<std::size_t> taken;
  std::vector<LidarPair> pairs;
  for (const LidarPair& pair : flight.pairs->pairs) {
    const std::size_t i = NodeBefore(node_t_s, pair.t_i_s), j = NodeBefore(node_t_s, pair.t_j_s);
    if (i == j || taken.contains(i) || taken.contains(j)) continue;
    taken.insert({i, j});
    pairs.push_back(pair);
  }
  return pairs;
}

// A node at every epoch gives the exact network. Eliminating such a node must give the same result
// as the bridge.
TEST(FlightNetwork, BridgesAreNodesAtTheEpochsEliminated) {
  Flight flight = DroneFlight().flight;
  ImuModel& model = flight.config.imu->model;
  model.gyro.white *= 20.0;   // 0.1 m at the ground within a second
  model.accel.white *= 10.0;  // tilts within an interval then do not affect the velocities
  model.gyro.processes = {{BiasProcess::Type::kRandomConstant, 1e-5, 0.0}};
  model.accel.processes = {{BiasProcess::Type::kRandomConstant, 1e-2, 0.0}};
  const TimeInterval span = NetworkSpan(flight, true);
  const std::vector<double> coarse = NodeTimes(*flight.imu, span, GnssTimes(flight, span), {}, {});
  const std::vector<LidarPair> pairs = OnePerInterval(flight, coarse);
  ASSERT_GE(pairs.size(), 15U);
  std::set<double> fine(coarse.begin(), coarse.end());
  for (const LidarPair& pair : pairs) fine.insert({pair.t_i_s, pair.t_j_s});

  struct Solved {
    double cost = 0.0;
    Eigen::Quaterniond boresight;
    Eigen::Matrix3d covariance;
  };
  const auto solve = [&](const std::vector<double>& node_t_s) {
    InitialStates initial;
    for (const double t_s : node_t_s) initial.nodes.push_back(DroneFlight().truth->Pose(t_s));
    FlightNetwork network(flight, node_t_s, initial);
    network.net().SetValue(network.calibration().boresight(), Exp(DroneFlight().boresight_rad));
    network.AddPairs(pairs);
    Solved solved;
    for (int k = 0; k < 3; ++k) {
      solved.cost = Solve(network.net()).final_cost;
      network.Repreintegrate();
    }
    solved.boresight = network.net().Value(network.calibration().boresight());
    solved.covariance = Marginals(network.net()).Covariance(network.calibration().boresight());
    return solved;
  };
  const Solved bridged = solve(coarse);
  const Solved exact = solve({fine.begin(), fine.end()});
  const Eigen::Vector3d sigma = exact.covariance.diagonal().cwiseSqrt();
  const Eigen::Vector3d apart = Log(bridged.boresight * exact.boresight.conjugate());
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(std::abs(apart[axis]), 0.05 * sigma[axis]) << axis;
    EXPECT_NEAR(bridged.covariance(axis, axis) / exact.covariance(axis, axis), 1.0, 0.01) << axis;
  }
  EXPECT_NEAR(bridged.cost / exact.cost, 1.0, 1e-3);
}

/// The plain factor of a pair with an additional unknown, a shift of its second point.
class ShiftedPair final : public DynamicAutoFactor<ShiftedPair>, public PointPairFactor {
 public:
  ShiftedPair(const LocalFrame& frame, const PreparedPair& parts)
      : DynamicAutoFactor(
            3, {Rotation::kKind, Vec<3>::kKind, Vec<3>::kKind, Rotation::kKind, Vec<3>::kKind,
                Vec<3>::kKind, LeftRotation::kKind, Vec<3>::kKind, Vec<1>::kKind, Vec<3>::kKind}),
        i_(frame, parts.i.partial, parts.i.p_nominal_m),
        j_(frame, parts.j.partial, parts.j.p_nominal_m),
        parts_(parts) {}

  template <class T>
  bool Residual(T const* const* x, T* r) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    const Vec3 d =
        Point(i_, parts_.i, x, x) - Point(j_, parts_.j, x + 3, x) - Eigen::Map<const Vec3>(x[9]);
    Eigen::Map<Vec3>(r).noalias() = parts_.noise_m.sqrt_information().cast<T>() * d;
    return true;
  }

  std::pair<Eigen::Vector3d, Eigen::Vector3d> Points(double const* const* x) const override {
    return {Point(i_, parts_.i, x, x), Point(j_, parts_.j, x + 3, x)};
  }

 private:
  template <class T>
  Eigen::Matrix<T, 3, 1> Point(const LidarPoint& point, const LidarEnd& end, T const* const* node,
                               T const* const* x) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    using Quaternion = Eigen::Quaternion<T>;
    const Vec3 u_b = (parts_.R_bs_nominal * end.u_s).cast<T>();
    return point.At<T>(Quaternion(node[0]), Vec3(node[1]), Vec3(node[2]), Quaternion(x[6]),
                       Vec3(x[7]), u_b, x[8][0] - parts_.dt_nominal_s);
  }

  LidarPoint i_, j_;
  PreparedPair parts_;
};

FlightNetworkOptions WithShift(Block<Vec<3>>* shift) {
  FlightNetworkOptions options;
  options.pair_model = [shift](FlightNetwork& network) {
    *shift = network.net().AddVector<3>("shift", Eigen::Vector3d::Zero());
    return PairModel{{shift->id}, [](const Flight& flight, const PreparedPair& parts) {
                       return std::make_shared<ShiftedPair>(flight.frame, parts);
                     }};
  };
  return options;
}

TEST(FlightNetwork, OwnFactorsOfPairsAreSolvedAndRenewed) {
  Flight flight = DroneFlight().flight;
  Block<Vec<3>> shift;
  FlightNetwork network = AtTruth(flight, WithShift(&shift));
  network.net().SetValue(network.calibration().boresight(), Exp(DroneFlight().boresight_rad));
  network.AddPairs(flight.pairs->pairs);
  ASSERT_EQ(network.pairs().edges().size(), 300U);
  for (int k = 0; k < 2; ++k) {
    EXPECT_TRUE(Solve(network.net()).converged);
    const auto before = network.net().factor(network.pairs().edges()[0].id).factor;
    network.Repreintegrate();
    const auto after = network.net().factor(network.pairs().edges()[0].id).factor;
    EXPECT_NE(before, after);
    EXPECT_NE(dynamic_cast<const ShiftedPair*>(after.get()), nullptr);
  }
  const Marginals marginals(network.net());
  const Eigen::Vector3d sigma = marginals.Covariance(shift).diagonal().cwiseSqrt();
  const Eigen::Vector3d in_sigmas = network.net().Value(shift).cwiseQuotient(sigma);
  EXPECT_LE(in_sigmas.cwiseAbs().maxCoeff(), 4.0);
  EXPECT_LE(sigma.maxCoeff(), 0.1);
  EXPECT_LE(network.pairs().Difference(0).norm(), 0.5);
}

// The sensitivity of a pair whose factor does not provide it equals that of the library's factor.
TEST(FlightNetwork, OwnFactorsOfPairsNeedNotSayWhatEffectsDo) {
  Block<Vec<3>> shift;
  FlightNetwork network = AtTruth(DroneFlight().flight, WithShift(&shift));
  network.AddPairs(DroneFlight().flight.pairs->pairs);
  const FactorId id = network.pairs().edges()[7].id;
  std::vector<const double*> x;
  for (const BlockId block : network.net().factor(id).blocks) {
    x.push_back(network.net().block(block).value.get());
  }
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> J_lever_arm;
  Eigen::Vector3d r, J_delay;
  std::vector<double*> J(x.size(), nullptr);
  J[7] = J_lever_arm.data();
  J[8] = J_delay.data();
  ASSERT_TRUE(network.net().EvaluateStored(id, x.data(), r.data(), J.data()));
  const PointSensitivity i = network.pairs().EndSensitivity({7, PointPairFactor::End::kI});
  const PointSensitivity j = network.pairs().EndSensitivity({7, PointPairFactor::End::kJ});
  EXPECT_LT((i.lever_arm + j.lever_arm - J_lever_arm).norm(), 1e-9 * i.lever_arm.norm());
  EXPECT_LT((i.delay + j.delay - J_delay).norm(), 1e-9 * i.delay.norm());
}

TEST(FlightNetwork, OwnFactorsOfPairsMustSayTheirPoints) {
  FlightNetworkOptions options;
  options.pair_model = [](FlightNetwork&) {
    return PairModel{{}, [](const Flight&, const PreparedPair&) {
                       return std::make_shared<PriorVector<3>>(Eigen::Vector3d::Zero(),
                                                               Noise<3>::Sigma(1.0));
                     }};
  };
  FlightNetwork network = AtTruth(DroneFlight().flight, options);
  testing::ExpectInvalid([&] { network.AddPairs(DroneFlight().flight.pairs->pairs); },
                         "is not a PointPairFactor", 0);
}

TEST(FlightNetwork, OwnFactorsOfPairsExcludeEstimatedEffectsOnPairs) {
  Flight flight = DroneFlight().flight;
  flight.config.estimate.push_back({.unknown = "lidar_range_offset"});
  Block<Vec<3>> shift;
  FlightNetwork network = AtTruth(flight, WithShift(&shift));
  testing::ExpectInvalid([&] { network.AddPairs(flight.pairs->pairs); },
                         "cannot estimate 'lidar_range_offset'", 0);
}

TEST(FlightNetwork, AReplacedFactorStays) {
  FlightNetwork network = AtTruth(DroneFlight().flight);
  network.AddPairs(DroneFlight().flight.pairs->pairs);
  const FactorId replaced = network.inertial().edges()[3].id;
  const auto own = std::make_shared<PreintegratedInertial>(
      dynamic_cast<const PreintegratedInertial&>(*network.net().factor(replaced).factor));
  network.net().ReplaceFactor(replaced, own);
  const auto other = network.net().factor(network.inertial().edges()[4].id).factor;
  network.Repreintegrate();
  EXPECT_EQ(network.net().factor(replaced).factor, own);
  EXPECT_NE(network.net().factor(network.inertial().edges()[4].id).factor, other);
}

TEST(FlightNetwork, StatesBetweenNodesFollowTheMotion) {
  SimulateOptions options;
  options.noise = false;
  options.seed = 7;
  const SimulatedFlight sim = Simulate(DroneScenario(), options);
  const FlightNetwork network = AtTruth(sim.flight);
  const std::vector<double>& times = network.trajectory().node_times();
  for (const double t_s : {times.front(), times[40] + 0.137, times[90] + 0.251, times.back()}) {
    const FlightNetwork::StateBetween at = network.StateAt(t_s);
    const MapPose node = network.trajectory().NodePose(at.node);
    const KinematicState<double> state = at.state.At<double>(node.q_mb, node.p_mb, node.v_m);
    const MapPose truth = sim.truth->Pose(t_s);
    EXPECT_LE((state.p_mb - truth.p_mb).norm(), 1e-5) << t_s;
    EXPECT_LE((state.v_m - truth.v_m).norm(), 1e-4) << t_s;
    EXPECT_LE(Log(state.q_mb.conjugate() * truth.q_mb).norm(), 1e-6) << t_s;
  }
  testing::ExpectInvalid([&] { (void)network.StateAt(times.back() + 1.0); }, "outside its nodes",
                         0);
}

TEST(FlightNetwork, AFactorBetweenNodesFollowsTheBiases) {
  FlightNetwork network = AtTruth(DroneFlight().flight);
  const double t_s = network.trajectory().node_times()[40] + 0.7;
  const auto shift = network.net().AddVector<3>("shift", Eigen::Vector3d(1.0, 2.0, 3.0));
  const auto whole_state = [](const auto& state, const auto& s) {
    using T = typename std::decay_t<decltype(state.v_m)>::Scalar;
    Eigen::Matrix<T, 9, 1> f;
    f << Log(state.q_mb), state.p_mb - s, state.v_m;
    return f;
  };
  const FactorId id = network.AddAt(t_s, whole_state, Noise<9>::Sigma(0.5), shift);
  network.net().SetValue(network.trajectory().gyro_bias().back().At(t_s),
                         Eigen::Vector3d(2e-4, -1e-4, 1e-4));
  network.net().SetValue(network.trajectory().accel_bias().back().At(t_s),
                         Eigen::Vector3d(0.02, 0.03, -0.05));

  Eigen::VectorXd r;
  ASSERT_TRUE(network.net().EvaluateFactor(id, &r));
  const FlightNetwork::StateBetween at = network.StateAt(t_s);  // integrated again
  const MapPose node = network.trajectory().NodePose(at.node);
  const KinematicState<double> state = at.state.At<double>(node.q_mb, node.p_mb, node.v_m);
  EXPECT_LE((0.5 * r.head<3>() - Log(state.q_mb)).norm(), 1e-8);
  EXPECT_LE((0.5 * r.segment<3>(3) - (state.p_mb - Eigen::Vector3d(1, 2, 3))).norm(), 1e-7);
  EXPECT_LE((0.5 * r.tail<3>() - state.v_m).norm(), 1e-6);
  EXPECT_EQ(network.net().factor(id).blocks.back(), shift.id);
  testing::ExpectInvalid(
      [&] {
        network.AddAt(
            1.0, [](const auto& s) { return s.v_m; }, Noise<3>::Sigma(1.0));
      },
      "outside its nodes", 0);
}

TEST(FlightNetwork, DerivativesFromMeansKeepTheIncrementsInUse) {
  constexpr double kUsualScale = 3e-4;
  const FlightNetwork network = AtTruth(DroneFlight().flight);
  CalibrationState with_scale = network.calibration().State();
  with_scale.Insert({"gyro_scale_factor",
                     FindEstimable("gyro_scale_factor")->make({network.flight(), {}}),
                     Eigen::Vector3d::Zero()});
  const ImuData means = AverageSamples(*network.flight().imu, 0.02);
  ASSERT_LE(means.samples.size(), network.flight().imu->samples.size() / 2);
  for (const InertialEdge& edge : network.inertial().edges()) {
    const Preintegrated whole = network.inertial().Factor(edge, with_scale)->increments();
    const auto factor = network.inertial().FactorByMeans(edge, with_scale, means);
    const Preintegrated& by_means = factor->increments();
    EXPECT_EQ(by_means.delta_q.coeffs(), whole.delta_q.coeffs());
    EXPECT_EQ(by_means.delta_p, whole.delta_p);
    EXPECT_EQ(by_means.covariance, whole.covariance);
    ASSERT_EQ(by_means.J_effects.cols(), 3);
    const Eigen::Matrix<double, 9, 3> difference = by_means.J_effects - whole.J_effects;
    const auto in_sigmas = whole.covariance.llt().matrixL().solve(difference).eval();
    EXPECT_LT(kUsualScale * in_sigmas.norm(), 2e-3);
    EXPECT_EQ(factor->block_kinds().size(),
              network.inertial().Factor(edge, with_scale)->block_kinds().size());
  }
}

TEST(FlightNetwork, NumberOfStartingPosesMustMatch) {
  InitialStates initial;
  initial.nodes.resize(2);
  testing::ExpectInvalid(
      [&] {
        FlightNetwork(DroneFlight().flight, {381001.0, 381002.0, 381003.0}, initial);
      },
      "2 starting poses for 3 nodes", 0);
}

TEST(FlightNetwork, RepreintegratingAConvergedNetworkChangesNothing) {
  Calibration calibration(DroneFlight().flight);
  FlightNetwork& network = *calibration.adjustment.network;
  const double cost = EvaluateCost(network.net()).cost;
  const Eigen::Quaterniond before = network.net().Value(network.calibration().boresight());
  network.Repreintegrate();
  EXPECT_EQ(network.inertial().BiasChange(), 0.0) << "no bias has moved in between";
  EXPECT_NEAR(EvaluateCost(network.net()).cost, cost, 1e-6 * cost);
  const SolveSummary summary = Solve(network.net());
  EXPECT_TRUE(summary.converged);
  const Eigen::Vector3d moved =
      Log(network.net().Value(network.calibration().boresight()) * before.conjugate());
  constexpr double kOfSigma = 1e-3;  // the last solution has a tolerance of 1e-10 of the cost
  EXPECT_LT(moved.cwiseQuotient(calibration.boresight.sigma_rad()).norm(), kOfSigma);
}

TEST(FlightNetwork, GnssCovarianceIsTheFilesElseTheDefaultScaled) {
  GnssConfig config;
  config.sigma_enu_m = {0.1, 0.2, 0.3};
  config.sigma_scale = 2.0;
  MapGnssEpoch epoch;
  const Eigen::Matrix3d expected = Eigen::Vector3d(0.04, 0.16, 0.36).asDiagonal();
  constexpr double kRounding = 1e-12;
  EXPECT_LT((GnssPositionCovariance(epoch, config) - expected).norm(), kRounding);
  epoch.covariance_enu_m2 = Eigen::Matrix3d::Identity();
  EXPECT_LT((GnssPositionCovariance(epoch, config) - 4.0 * Eigen::Matrix3d::Identity()).norm(),
            kRounding);
  // At 90 deg east on the equator, up is the direction east of the map frame.
  epoch.covariance_enu_m2 = Eigen::Matrix3d(Eigen::Vector3d(1.0, 2.0, 3.0).asDiagonal());
  const LocalFrame equator{Geodetic{}};
  GnssData east;
  east.epochs.resize(1);
  east.epochs[0].antenna = {0.0, 90.0 * kRadPerDeg, 0.0};
  epoch.R_m_enu = ToMap(east, equator).epochs[0].R_m_enu;
  const Eigen::Matrix3d turned = Eigen::Vector3d(12.0, 8.0, 4.0).asDiagonal();
  EXPECT_LT((GnssPositionCovariance(epoch, config) - turned).norm(), 1e-9);
}

TEST(FlightNetwork, GnssVelocitiesMayHaveTheirOwnScale) {
  GnssConfig config;
  config.sigma_scale = 2.0;
  MapGnssEpoch epoch;
  epoch.R_m_enu.setIdentity();
  epoch.velocity_covariance_enu = Eigen::Matrix3d::Identity();
  EXPECT_EQ(GnssVelocityCovariance(epoch, config), 4.0 * Eigen::Matrix3d::Identity());
  config.velocity_sigma_scale = 3.0;
  EXPECT_EQ(GnssVelocityCovariance(epoch, config), 9.0 * Eigen::Matrix3d::Identity());
}

TEST(FlightNetwork, VelocitiesAreUsedWithTheirSigmasUnlessSwitchedOff) {
  GnssConfig config;
  MapGnssEpoch epoch;
  EXPECT_FALSE(UsesVelocity(epoch, config));
  epoch.velocity_enu_mps = Eigen::Vector3d::Zero();
  EXPECT_FALSE(UsesVelocity(epoch, config)) << "no sigma";
  epoch.velocity_covariance_enu = Eigen::Matrix3d::Identity();
  EXPECT_TRUE(UsesVelocity(epoch, config));
  config.use_velocity = false;
  EXPECT_FALSE(UsesVelocity(epoch, config));
}

/// r = (height of the body - reading - offset) / sigma, for a user-defined sensor with its own
/// unknown.
struct Altimeter : AutoFactor<Altimeter, 1, Vec<3>, Vec<1>> {
  double reading_m = 0.0, sigma_m = 1.0;
  template <class T>
  bool Residual(const T* p_mb, const T* offset, T* r) const {
    r[0] = (p_mb[2] - reading_m - offset[0]) / sigma_m;
    return true;
  }
};

/// r = (a - b) / 1, which leaves the sum of both undetermined.
struct Tie : AutoFactor<Tie, 1, Vec<1>, Vec<1>> {
  template <class T>
  bool Residual(const T* a, const T* b, T* r) const {
    r[0] = a[0] - b[0];
    return true;
  }
};

TEST(FlightNetwork, OwnBlockAndFactorAreSolvedWithTheRest) {
  constexpr double kOffsetM = 12.5, kSigmaM = 0.01;
  Block<Vec<1>> offset;
  AdjustOptions options;
  options.customise = [&](FlightNetwork& network) {
    offset = network.net().AddVector<1>("altimeter_offset", Eigen::Matrix<double, 1, 1>(0.0));
    for (std::size_t k = 100; k < 200; ++k) {
      Altimeter f;
      f.reading_m = DroneFlight().truth->Pose(network.nodes()[k].t_s).p_mb.z() - kOffsetM;
      f.sigma_m = kSigmaM;
      network.net().Tag(network.net().Add(f, network.nodes()[k].p_mb, offset), "altimeter",
                        network.nodes()[k].t_s);
    }
  };
  const Calibration calibration(DroneFlight().flight, options);
  const Network& net = calibration.adjustment.network->net();
  const double sigma_m =
      std::sqrt(calibration.marginals.Covariance(net.Find("altimeter_offset"))(0, 0));
  EXPECT_GT(sigma_m, 0.1 * kSigmaM);
  EXPECT_LT(sigma_m, kSigmaM) << "a hundred readings against GNSS of 3 cm";
  EXPECT_NEAR(net.Value(offset)[0], kOffsetM, 4.0 * sigma_m);
  EXPECT_EQ(GroupCounts(net)["altimeter"], 100);
}

TEST(FlightNetwork, AnOwnUnknownWithoutInformationIsNamed) {
  AdjustOptions options;
  options.customise = [](FlightNetwork& network) {
    const auto a = network.net().AddVector<1>("my_first", Eigen::Matrix<double, 1, 1>(1.0));
    const auto b = network.net().AddVector<1>("my_second", Eigen::Matrix<double, 1, 1>(0.0));
    network.net().Add(Tie(), a, b);
  };
  const Adjustment adjustment = Adjust(DroneFlight().flight, options);
  try {
    const Marginals marginals(adjustment.network->net());
    FAIL() << "no RankDeficient";
  } catch (const RankDeficient& e) {
    EXPECT_THAT(e.what(), HasSubstr("my_first"));
    EXPECT_THAT(e.what(), HasSubstr("my_second"));
  }
}

}  // namespace dn::builder_test
