#include <dn/builder/flight_network.h>
#include <dn/effects/effect_table.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/factors/prior.h>
#include <dn/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "factor_groups.h"

namespace dn {
namespace {

// Units of FlightNetwork::BiasChange: a bias change of one unit makes the first-order correction of
// an increment inaccurate.
constexpr double kGyroStepRadps = 30.0 / kDegPerRad / 3600.0;
constexpr double kAccelStepMps2 = 5e-3 * kStandardGravityMps2;
// The same unit for an effect, as a multiple of its typical sizes.
constexpr double kEffectStep = 10.0;
// Limit for counting white noise twice. Below this fraction of the variance of a pair, the white
// noise of the increments to its epochs is also counted in the inertial edges. The sum of squares
// is then too small by at most this fraction.
constexpr double kNoiseCountedTwice = 1e-4;
constexpr double kOnNodeS = 2e-6;
// Pairs per batch; the increments of one batch need little memory compared with the network.
constexpr std::size_t kPairsAtOnce = 1 << 15;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

BlockLabel Label(const std::string& quantity, std::vector<std::string> components,
                 const std::string& unit, double per_si,
                 double t_s = std::numeric_limits<double>::quiet_NaN()) {
  return {quantity, std::move(components), unit, per_si, t_s};
}

const std::vector<std::string> kXyz{"x", "y", "z"};

BlockId AddVectorBlock(const std::string& name, const Eigen::VectorXd& value, Network* net) {
  switch (value.size()) {
    case 1:
      return net->AddVector<1>(name, value).id;
    case 2:
      return net->AddVector<2>(name, value).id;
    case 3:
      return net->AddVector<3>(name, value).id;
    default:
      throw InvalidInput("effect '" + name + "' has " + std::to_string(value.size()) +
                         " values, but only effects with one to three values can be estimated");
  }
}

template <int N>
FactorId AddSizedPrior(BlockId block, const Eigen::VectorXd& center, const Eigen::VectorXd& sigma,
                       Network* net) {
  const Eigen::Matrix<double, N, 1> sigmas = sigma;
  return net->Add(PriorVector<N>(center, Noise<N>::Sigma(sigmas)), Block<Vec<N>>{block});
}

FactorId AddPrior(BlockId block, const Eigen::VectorXd& center, const Eigen::VectorXd& sigma,
                  Network* net) {
  if (center.size() == 1) return AddSizedPrior<1>(block, center, sigma, net);
  if (center.size() == 2) return AddSizedPrior<2>(block, center, sigma, net);
  return AddSizedPrior<3>(block, center, sigma, net);
}

/// Returns the label of an effect of the effect table, or a plain label for a user-defined effect.
BlockLabel EffectLabel(const std::string& name, Eigen::Index size) {
  const EffectSpec* spec = FindEffect(name);
  const EstimableEffect* effect = FindEstimable(name);
  if (spec == nullptr || effect == nullptr) return Label(name, {}, "", 1.0);
  std::vector<std::string> components;
  for (const EffectComponent& one : spec->components) components.push_back(one.name);
  components.resize(static_cast<std::size_t>(size));
  return Label(effect->quantity, components, spec->components[0].unit,
               1.0 / spec->components[0].to_si);
}

/// Returns the largest component of a change in typical sizes of the effect; for a user-defined
/// effect in units of its value.
double InTypicalSizes(const CalibrationValue& before, const Eigen::VectorXd& now) {
  const EffectSpec* spec = FindEffect(before.name);
  double largest = 0.0;
  for (Eigen::Index k = 0; k < now.size(); ++k) {
    const double usual =
        spec == nullptr ? 1.0 : spec->components[static_cast<std::size_t>(k)].typical_si();
    largest = std::max(largest, std::abs(now[k] - before.value[k]) / usual);
  }
  return largest;
}

/// A pair end with the node to which it is attached.
struct AttachedEnd {
  FlightNetwork::PairEndIndex end;
  std::size_t node;
  double epoch_s;
};

/// Returns the pair ends sorted by node, then by time.
std::vector<AttachedEnd> EndsInOrder(std::span<const FlightNetwork::PairEdge> edges,
                                     const PairCalibration& calibration) {
  std::vector<AttachedEnd> ends;
  ends.reserve(2 * edges.size());
  const auto epoch = [&](double tag_s, const Eigen::Vector3d& u_s) {
    return calibration.EmissionTime(calibration.Read(tag_s, u_s));
  };
  using End = PointPairFactor::End;
  for (std::size_t k = 0; k < edges.size(); ++k) {
    const LidarPair& pair = edges[k].pair;
    ends.push_back({{k, End::kI}, edges[k].node_i, epoch(pair.t_i_s, pair.u_i_s)});
    ends.push_back({{k, End::kJ}, edges[k].node_j, epoch(pair.t_j_s, pair.u_j_s)});
  }
  std::sort(ends.begin(), ends.end(), [](const AttachedEnd& a, const AttachedEnd& b) {
    return std::tie(a.node, a.epoch_s) < std::tie(b.node, b.epoch_s);
  });
  return ends;
}

/// Calls use(end, increments) for all ends; ends of different nodes are processed in parallel.
/// from_node(node) returns the EndIncrements of a node.
template <class FromNode, class Use>
void ForEnds(const std::vector<AttachedEnd>& ends, int threads, const FromNode& from_node,
             const Use& use) {
  std::vector<std::size_t> firsts;  // index of the first end of each node
  for (std::size_t k = 0; k < ends.size(); ++k) {
    if (k == 0 || ends[k].node != ends[k - 1].node) firsts.push_back(k);
  }
  firsts.push_back(ends.size());
  ParallelFor(static_cast<int>(firsts.size()) - 1, threads, [&](int n) {
    const std::size_t first = firsts[static_cast<std::size_t>(n)];
    EndIncrements increments = from_node(ends[first].node);
    for (std::size_t k = first; k < firsts[static_cast<std::size_t>(n) + 1]; ++k) {
      use(ends[k].end, increments.To(ends[k].epoch_s));
    }
  });
}

}  // namespace

FlightNetwork::FlightNetwork(const Flight& flight, const std::vector<double>& node_t_s,
                             const InitialStates& initial, const FlightNetworkOptions& options)
    : flight_(&flight), node_t_s_(node_t_s), options_(options) {
  const ImuModel& model = flight.config.imu->model;
  noise_ = {model.gyro.white, model.accel.white, options.position_floor_m, model.vibration};
  const CalibrationState assumed = AssumedCalibration(flight);
  const CalibrationState& calibration = initial.calibration ? *initial.calibration : assumed;
  AddMounting(calibration);
  AddEffects(calibration);
  AddPriors();
  AddNodes(initial);
  AddBiases(initial);
  AddGnssErrors();
  AddInertialEdges();
  AddGnssEdges();
}

bool FlightNetwork::Estimated(const std::string& unknown) const {
  const auto& estimate = flight_->config.estimate;
  return std::any_of(estimate.begin(), estimate.end(),
                     [&](const EstimateEntry& entry) { return entry.unknown == unknown; });
}

void FlightNetwork::AddMounting(const CalibrationState& calibration) {
  boresight = net.AddLeftRotation("boresight", calibration.q_boresight);
  gnss_lever_arm =
      net.AddVector<3>(EffectName(EffectId::kGnssLeverArm), calibration.gnss_lever_arm_b_m);
  lidar_lever_arm =
      net.AddVector<3>(EffectName(EffectId::kLidarLeverArm), calibration.lidar_lever_arm_b_m);
  lidar_time_offset =
      net.AddVector<1>(EffectName(EffectId::kLidarTimeOffset),
                       Eigen::Matrix<double, 1, 1>(calibration.lidar_time_offset_s));
  net.SetLabel(boresight.id, Label("boresight", {"roll", "pitch", "yaw"}, "deg", kDegPerRad));
  net.SetLabel(gnss_lever_arm.id, Label("GNSS lever arm", kXyz, "m", 1.0));
  net.SetLabel(lidar_lever_arm.id, Label("lidar lever arm", kXyz, "m", 1.0));
  net.SetLabel(lidar_time_offset.id, Label("lidar time offset", {"t"}, "s", 1.0));
  net.Hold(boresight, !flight_->config.lidar || !Estimated("boresight"));
  net.Hold(gnss_lever_arm, !Estimated(EffectName(EffectId::kGnssLeverArm)));
  net.Hold(lidar_lever_arm, !Estimated(EffectName(EffectId::kLidarLeverArm)));
  net.Hold(lidar_time_offset, !Estimated(EffectName(EffectId::kLidarTimeOffset)));
}

void FlightNetwork::AddEffects(const CalibrationState& calibration) {
  for (const CalibrationValue& one : calibration.effects) {
    const BlockId id = AddVectorBlock(one.name, one.value, &net);
    net.SetLabel(id, EffectLabel(one.name, one.value.size()));
    net.Hold(id, !Estimated(one.name));
    effects.push_back({one.name, one.action, id});
  }
  linearised_ = calibration;
}

void FlightNetwork::AddPriors() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const FlightConfig& config = flight_->config;
  if (config.lidar && config.lidar->boresight_sigma_rad) {
    const FactorId id =
        net.Add(PriorLeftRotation(Exp(config.lidar->mounting.boresight_rad),
                                  Noise<3>::Sigma(*config.lidar->boresight_sigma_rad)),
                boresight);
    net.Tag(id, internal::PriorGroup(), nan);
  }
  for (const EstimateEntry& entry : config.estimate) {
    if (entry.unknown == "boresight" || entry.sigma.empty()) continue;
    const BlockId block = net.Find(entry.unknown);
    net.Tag(AddPrior(block, AssumedValue(*flight_, entry.unknown), *PriorSigma(entry), &net),
            internal::PriorGroup(), nan);
  }
}

void FlightNetwork::AddNodes(const InitialStates& initial) {
  if (initial.nodes.size() != node_t_s_.size()) {
    throw InvalidInput("flight network: " + std::to_string(initial.nodes.size()) +
                       " starting poses for " + std::to_string(node_t_s_.size()) + " nodes");
  }
  nodes.reserve(node_t_s_.size());
  for (std::size_t k = 0; k < node_t_s_.size(); ++k) {
    const MapPose& pose = initial.nodes[k];
    const std::string suffix = "/" + std::to_string(k);
    NodeBlocks node;
    node.t_s = node_t_s_[k];
    node.q_mb = net.AddRotation("q_mb" + suffix, pose.q_mb);
    node.p_mb = net.AddVector<3>("p_mb" + suffix, pose.p_mb);
    node.v_m = net.AddVector<3>("v_m" + suffix, pose.v_m);
    net.SetLabel(node.q_mb.id, Label("attitude", {"about body x", "about body y", "about body z"},
                                     "deg", kDegPerRad, node.t_s));
    net.SetLabel(node.p_mb.id, Label("position", {"east", "north", "up"}, "m", 1.0, node.t_s));
    net.SetLabel(node.v_m.id, Label("velocity", {"east", "north", "up"}, "m/s", 1.0, node.t_s));
    nodes.push_back(node);
  }
}

double FlightNetwork::ConstantIntervalLength(const BiasProcess& process) const {
  switch (process.type) {
    case BiasProcess::Type::kGaussMarkov:
      return std::min(process.tau_s * options_.bias_interval_per_tau, options_.bias_interval_max_s);
    case BiasProcess::Type::kRandomWalk:
      return options_.bias_interval_max_s;
    case BiasProcess::Type::kRandomConstant:
      break;
  }
  return node_t_s_.back() - node_t_s_.front();
}

void FlightNetwork::AddBiases(const InitialStates& initial) {
  const ImuModel& model = flight_->config.imu->model;
  const auto add_all = [&](const SensorNoise& sensor, ChainNames names, Eigen::Vector3d start,
                           std::vector<ProcessChain>* chains) {
    const std::string triad = names.name;
    for (const BiasProcess& process : sensor.processes) {
      names.name = triad + std::to_string(chains->size());
      chains->push_back(
          AddProcessChain(process, IntervalsOverNodes(node_t_s_, ConstantIntervalLength(process)),
                          names, start, &net));
      start.setZero();  // the first process has the whole initial value
    }
  };
  const FactorGroup& prior = internal::PriorGroup();
  add_all(model.gyro,
          {"gyro_bias/", "gyro bias", kXyz, "deg/h", kDegPerRad * 3600.0,
           internal::BiasProcessGroup(true), prior},
          initial.gyro_bias_radps, &gyro_bias);
  add_all(model.accel,
          {"accel_bias/", "accelerometer bias", kXyz, "mg", 1e3 / kStandardGravityMps2,
           internal::BiasProcessGroup(false), prior},
          initial.accel_bias_mps2, &accel_bias);
}

void FlightNetwork::AddGnssErrors() {
  if (!flight_->gnss) return;
  const GnssConfig& config = *flight_->config.gnss;
  const TimeInterval span{node_t_s_.front() - kOnNodeS, node_t_s_.back() + kOnNodeS};
  std::vector<double> epoch_t_s;
  Eigen::Array3d least_variance = Eigen::Array3d::Constant(kInfinity);
  for (const MapGnssEpoch& epoch : flight_->gnss->epochs) {
    if (epoch.t_s < span.t0_s || epoch.t_s > span.t1_s) continue;
    epoch_t_s.push_back(epoch.t_s);
    least_variance = least_variance.min(GnssPositionCovariance(epoch, config).diagonal().array());
  }
  if (epoch_t_s.empty()) return;
  for (const BiasProcess& process : GnssProcessesInSigmas(config)) {
    const std::size_t i = gnss_error.size();
    const double white_share =
        (least_variance / config.processes[i].sigma_enu_m.array().square()).minCoeff();
    const double length_s = ConstantIntervalLength(process) * std::min(1.0, white_share);
    gnss_error.push_back(AddProcessChain(process, IntervalsOverEpochs(epoch_t_s, length_s),
                                         {"gnss_error/" + std::to_string(i),
                                          "GNSS error",
                                          {"east", "north", "up"},
                                          "sigma",
                                          1.0,
                                          internal::GnssErrorGroup(),
                                          internal::PriorGroup()},
                                         Eigen::Vector3d::Zero(), &net));
  }
}

Eigen::Vector3d FlightNetwork::GyroBias(double t_s) const {
  return SumProcesses(net, gyro_bias, t_s);
}
Eigen::Vector3d FlightNetwork::AccelBias(double t_s) const {
  return SumProcesses(net, accel_bias, t_s);
}

Eigen::Vector3d FlightNetwork::GnssErrorEnu(double t_s) const {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < gnss_error.size(); ++i) {
    sum_m += flight_->config.gnss->processes[i].sigma_enu_m.cwiseProduct(
        net.Value(gnss_error[i].At(t_s)));
  }
  return sum_m;
}

ImuCorrection FlightNetwork::BiasesAt(std::size_t k) const {
  return {GyroBias(node_t_s_[k]), AccelBias(node_t_s_[k])};
}

MapPose FlightNetwork::NodePose(std::size_t k) const {
  const NodeBlocks& node = nodes[k];
  return {node.t_s, net.Value(node.q_mb), net.Value(node.p_mb), net.Value(node.v_m)};
}

CalibrationState FlightNetwork::Calibration() const {
  CalibrationState state;
  state.q_boresight = net.Value(boresight);
  state.gnss_lever_arm_b_m = net.Value(gnss_lever_arm);
  state.lidar_lever_arm_b_m = net.Value(lidar_lever_arm);
  state.lidar_time_offset_s = net.Value(lidar_time_offset)[0];
  for (const EffectBlock& effect : effects) {
    const BlockRecord& block = net.block(effect.id);
    state.effects.push_back(
        {effect.name, effect.action,
         Eigen::Map<const Eigen::VectorXd>(block.value.get(), block.kind.stored_size)});
  }
  return state;
}

void FlightNetwork::AppendEffects(const std::vector<std::size_t>& indices,
                                  std::vector<BlockId>* blocks) const {
  for (const std::size_t k : indices) blocks->push_back(effects[k].id);
}

std::shared_ptr<const PreintegratedInertial> FlightNetwork::InertialFactorOn(
    const Preintegrated& increments, const InertialEdge& edge,
    const CalibrationState& calibration) const {
  const std::size_t i = edge.node_i;
  const Eigen::Vector3d p_i = net.Value(nodes[i].p_mb);
  return std::make_shared<PreintegratedInertial>(
      increments, flight_->frame, p_i, net.Value(nodes[i + 1].p_mb),
      static_cast<int>(gyro_bias.size()), static_cast<int>(accel_bias.size()),
      GravitationJacobians(calibration, p_i));
}

std::shared_ptr<const PreintegratedInertial> FlightNetwork::InertialFactor(
    const InertialEdge& edge, const CalibrationState& calibration) const {
  const double t_s = node_t_s_[edge.node_i];
  const Preintegrated increments =
      Preintegrate(*flight_->imu, t_s, node_t_s_[edge.node_i + 1],
                   calibration.ImuAt(GyroBias(t_s), AccelBias(t_s)), noise_);
  return InertialFactorOn(increments, edge, calibration);
}

std::shared_ptr<const PreintegratedInertial> FlightNetwork::InertialFactorByMeans(
    const InertialEdge& edge, const CalibrationState& calibration, const ImuData& imu) const {
  Preintegrated increments = InertialFactorInUse(edge)->increments();
  const ImuCorrection correction = calibration.ImuAt(increments.linearisation.gyro_bias_radps,
                                                     increments.linearisation.accel_bias_mps2);
  if (!correction.effects.empty()) {
    increments.J_effects =
        Preintegrate(imu, increments.t_begin_s, increments.t_end_s, correction, {}).J_effects;
  }
  increments.linearisation = correction;
  return InertialFactorOn(increments, edge, calibration);
}

void FlightNetwork::AddInertialEdges() {
  const CalibrationState calibration = Calibration();
  const std::vector<std::size_t> effect_indices = InertialEffectIndices(calibration);
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    if (HasGap(*flight_->imu, node_t_s_[i], node_t_s_[i + 1])) continue;
    inertial_edges.push_back({i, -1});
    linearised_gyro_bias_.push_back(GyroBias(node_t_s_[i]));
    linearised_accel_bias_.push_back(AccelBias(node_t_s_[i]));
  }
  const auto factors = InertialFactors(calibration);
  for (std::size_t e = 0; e < inertial_edges.size(); ++e) {
    const std::size_t i = inertial_edges[e].node_i;
    std::vector<BlockId> blocks = StateBlocks(i);
    blocks.insert(blocks.begin() + 3,
                  {nodes[i + 1].q_mb.id, nodes[i + 1].p_mb.id, nodes[i + 1].v_m.id});
    AppendEffects(effect_indices, &blocks);
    inertial_edges[e].id = AddEdge(factors[e], blocks, internal::InertialGroup(), node_t_s_[i]);
  }
}

std::vector<std::shared_ptr<const PreintegratedInertial>> FlightNetwork::InertialFactors(
    const CalibrationState& calibration) const {
  std::vector<std::shared_ptr<const PreintegratedInertial>> factors(inertial_edges.size());
  ParallelFor(static_cast<int>(factors.size()), options_.threads, [&](int e) {
    const auto k = static_cast<std::size_t>(e);
    factors[k] = InertialFactor(inertial_edges[k], calibration);
  });
  return factors;
}

std::shared_ptr<const FactorBase> FlightNetwork::GnssPositionFactor(
    const GnssEdge& edge, const CalibrationState& calibration) const {
  const MapGnssEpoch& epoch = flight_->gnss->epochs[edge.epoch];
  return MakeGnssPositionFactor(*flight_, epoch, calibration,
                                {NodePose(edge.node), {GyroBias(epoch.t_s), AccelBias(epoch.t_s)}});
}

std::shared_ptr<const FactorBase> FlightNetwork::GnssVelocityFactor(
    const GnssEdge& edge, const CalibrationState& calibration) const {
  const MapGnssEpoch& epoch = flight_->gnss->epochs[edge.epoch];
  return MakeGnssVelocityFactor(*flight_, epoch, calibration,
                                {NodePose(edge.node), {GyroBias(epoch.t_s), AccelBias(epoch.t_s)}});
}

void FlightNetwork::AddGnssEdges() {
  if (!flight_->gnss) return;
  const CalibrationState calibration = Calibration();
  const std::vector<std::size_t> effect_indices = GnssEffectIndices(calibration);
  const GnssConfig& config = *flight_->config.gnss;
  const auto& epochs = flight_->gnss->epochs;
  for (std::size_t e = 0; e < epochs.size(); ++e) {
    const MapGnssEpoch& epoch = epochs[e];
    const double t_s = GnssEpochTime(calibration, epoch.t_s);
    const std::size_t k = NodeBefore(node_t_s_, t_s + 1e-6);
    // The epoch is outside the time span of the network.
    if (std::abs(node_t_s_[k] - t_s) > kOnNodeS) continue;
    GnssEdge edge{k, e, -1, -1};
    std::vector<BlockId> position{nodes[k].q_mb.id, nodes[k].p_mb.id, gnss_lever_arm.id};
    std::vector<BlockId> velocity{nodes[k].q_mb.id, nodes[k].v_m.id, gnss_lever_arm.id};
    const std::vector<BlockId> antenna{nodes[k].q_mb.id, nodes[k].p_mb.id, gnss_lever_arm.id,
                                       nodes[k].v_m.id};
    if (!effect_indices.empty() || !gnss_error.empty()) {
      position = antenna;
      for (const ProcessChain& chain : gnss_error) position.push_back(chain.At(epoch.t_s).id);
      AppendEffects(effect_indices, &position);
    }
    if (!effect_indices.empty()) {
      velocity = antenna;
      AppendEffects(effect_indices, &velocity);
    }
    edge.position = AddEdge(GnssPositionFactor(edge, calibration), position,
                            internal::GnssPositionGroup(), epoch.t_s);
    if (UsesVelocity(epoch, config)) {
      edge.velocity = AddEdge(GnssVelocityFactor(edge, calibration), velocity,
                              internal::GnssVelocityGroup(), epoch.t_s);
    }
    gnss_edges.push_back(edge);
  }
}

std::shared_ptr<const PreintegratedInertial> FlightNetwork::InertialFactorInUse(
    const InertialEdge& edge) const {
  auto in_use = std::dynamic_pointer_cast<const PreintegratedInertial>(net.factor(edge.id).factor);
  return in_use ? in_use : InertialFactor(edge, linearised_);  // the caller has replaced the factor
}

std::vector<FlightNetwork::PairIncrements> FlightNetwork::IntegratePairIncrements(
    std::span<const PairEdge> edges, const PairCalibration& calibration) const {
  std::vector<PairIncrements> increments(edges.size());
  const auto from_node = [&](std::size_t node) {
    return EndIncrements(*flight_->imu, calibration.state(), noise_, node_t_s_[node],
                         BiasesAt(node));
  };
  ForEnds(EndsInOrder(edges, calibration), options_.threads, from_node,
          [&](const PairEndIndex& end, Preintegrated of_end) {
            PairIncrements& of_pair = increments[end.k];
            (end.end == PointPairFactor::End::kI ? of_pair.i : of_pair.j) = std::move(of_end);
          });
  return increments;
}

void FlightNetwork::ForPairEnds(const CalibrationState& calibration, const ImuData& imu,
                                int threads, const UsePairEnd& use) const {
  const PreintegrationNoise none;
  const auto from_node = [&](std::size_t node) {
    return EndIncrements(imu, calibration, none, node_t_s_[node], BiasesAt(node));
  };
  ForEnds(EndsInOrder(pair_edges, PairCalibration(calibration)), threads, from_node, use);
}

PairEdgeInput FlightNetwork::MakeEdgeInput(const PairEdge& edge,
                                           const PairIncrements& increments) const {
  const auto end = [&](std::size_t k, const std::optional<std::size_t>& bridge,
                       const Preintegrated& partial) {
    return PairEndInput{NodePose(k), BiasesAt(k),
                        bridge ? InertialFactorInUse(inertial_edges[*bridge]) : nullptr, &partial};
  };
  return {edge.pair, end(edge.node_i, edge.bridge_i, increments.i),
          end(edge.node_j, edge.bridge_j, increments.j)};
}

template <class Work>
void FlightNetwork::ForPairs(std::span<PairEdge> edges, const CalibrationState& calibration,
                             const Work& work) const {
  const PairCalibration pair_calibration(calibration);
  for (std::size_t first = 0; first < edges.size(); first += kPairsAtOnce) {
    const auto some = edges.subspan(first, std::min(kPairsAtOnce, edges.size() - first));
    const std::vector<PairIncrements> increments = IntegratePairIncrements(some, pair_calibration);
    std::vector<std::shared_ptr<const FactorBase>> made(pair_model_ ? 0 : some.size());
    ParallelFor(static_cast<int>(made.size()), options_.threads, [&](int at) {
      const auto k = static_cast<std::size_t>(at);
      made[k] = PairFactor(some[k], pair_calibration, increments[k]);
    });
    for (std::size_t k = 0; k < some.size(); ++k) {
      work(some[k], [&] {
        return pair_model_ ? ModelPairFactor(some[k], pair_calibration, increments[k])
                           : std::move(made[k]);
      });
    }
  }
}

std::shared_ptr<const FactorBase> FlightNetwork::PairFactor(
    const PairEdge& edge, const PairCalibration& calibration,
    const PairIncrements& increments) const {
  return MakePairFactor(*flight_, calibration, noise_, MakeEdgeInput(edge, increments));
}

std::shared_ptr<const FactorBase> FlightNetwork::ModelPairFactor(
    const PairEdge& edge, const PairCalibration& calibration,
    const PairIncrements& increments) const {
  auto factor = pair_model_->make(
      *flight_, MakePairParts(*flight_, calibration, noise_, MakeEdgeInput(edge, increments)));
  if (dynamic_cast<const PointPairFactor*>(factor.get()) == nullptr) {
    throw InvalidInput(
        "pair model: the factor of the pair at t = " + std::to_string(edge.pair.t_i_s) +
        " s is not a PointPairFactor; derive its class from PointPairFactor");
  }
  return factor;
}

void FlightNetwork::RequestPairModel() {
  if (!options_.pair_model || pair_model_) return;
  pair_model_ = options_.pair_model(*this);
  const std::vector<std::size_t> pair_effects = PairEffectIndices(Calibration());
  if (pair_effects.empty()) return;
  throw InvalidInput("pair model: factors of a pair model cannot estimate '" +
                     effects[pair_effects.front()].name + "'; remove it from `estimate`");
}

bool FlightNetwork::MovesLidarEpochs() const {
  const auto moves = [](const EffectBlock& effect) {
    const auto* lidar = std::get_if<std::shared_ptr<const LidarEffect>>(&effect.action);
    return lidar != nullptr && (*lidar)->moves_epochs();
  };
  return !net.block(lidar_time_offset.id).held ||
         std::any_of(effects.begin(), effects.end(), moves);
}

FlightNetwork::PairEdge FlightNetwork::AttachToNodes(const LidarPair& pair, double margin_s) const {
  PairEdge edge;
  edge.pair = pair;
  edge.node_i = NodeBefore(node_t_s_, pair.t_i_s - margin_s);
  edge.node_j = NodeBefore(node_t_s_, pair.t_j_s - margin_s);
  return edge;
}

// The noise of an end must not be conditioned on the attitude of the node of the other end. Pairs
// whose ends follow neighbouring nodes therefore have no bridge.
void FlightNetwork::Bridge(PairEdge* edge) const {
  const auto [first, second] = std::minmax(edge->node_i, edge->node_j);
  if (second - first < 2) return;
  const double variance_m2 = edge->pair.covariance_m2 ? edge->pair.covariance_m2->trace() / 3.0
                                                      : flight_->config.lidar->sigma_p_m *
                                                            flight_->config.lidar->sigma_p_m;
  const auto bridge_of = [&](std::size_t node, double range_m) -> std::optional<std::size_t> {
    const auto at = std::lower_bound(
        inertial_edges.begin(), inertial_edges.end(), node,
        [](const InertialEdge& inertial, std::size_t k) { return inertial.node_i < k; });
    if (at == inertial_edges.end() || at->node_i != node) return std::nullopt;
    const auto k = static_cast<std::size_t>(at - inertial_edges.begin());
    const double turn_rad2 = InertialFactorInUse(inertial_edges[k])->increments().covariance(0, 0);
    const double added_m2 = turn_rad2 * range_m * range_m;
    if (added_m2 <= kNoiseCountedTwice * variance_m2) return std::nullopt;
    return k;
  };
  edge->bridge_i = bridge_of(edge->node_i, edge->pair.u_i_s.norm());
  edge->bridge_j = bridge_of(edge->node_j, edge->pair.u_j_s.norm());
}

std::vector<BlockId> FlightNetwork::PairBlocks(const PairEdge& edge) const {
  std::vector<BlockId> blocks;
  const auto add_node = [&](std::size_t k) {
    blocks.insert(blocks.end(), {nodes[k].q_mb.id, nodes[k].p_mb.id, nodes[k].v_m.id});
  };
  add_node(edge.node_i);
  add_node(edge.node_j);
  blocks.insert(blocks.end(), {boresight.id, lidar_lever_arm.id, lidar_time_offset.id});
  if (edge.bridge_i) blocks.push_back(nodes[edge.node_i + 1].q_mb.id);
  if (edge.bridge_j) blocks.push_back(nodes[edge.node_j + 1].q_mb.id);
  if (pair_model_) {
    blocks.insert(blocks.end(), pair_model_->blocks.begin(), pair_model_->blocks.end());
  }
  return blocks;
}

void FlightNetwork::AddPairs(const std::vector<LidarPair>& pairs) {
  const double margin_s = MovesLidarEpochs() ? kLidarTimeMarginS : -1e-7;
  const CalibrationState calibration = Calibration();
  const std::vector<std::size_t> effect_indices = PairEffectIndices(calibration);
  RequestPairModel();
  std::vector<PairEdge> edges;
  for (const LidarPair& pair : pairs) {
    PairEdge edge = AttachToNodes(pair, margin_s);
    if (edge.node_i == edge.node_j) {
      ++pairs_within_one_node;
      continue;
    }
    if (HasGap(*flight_->imu, node_t_s_[edge.node_i], pair.t_i_s) ||
        HasGap(*flight_->imu, node_t_s_[edge.node_j], pair.t_j_s)) {
      ++pairs_in_imu_gaps;
      continue;
    }
    if (!pair_model_) Bridge(&edge);
    edges.push_back(edge);
  }
  ForPairs(edges, calibration, [&](PairEdge& edge, const auto& make) {
    std::vector<BlockId> blocks = PairBlocks(edge);
    AppendEffects(effect_indices, &blocks);
    edge.id = AddEdge(make(), blocks, internal::PairGroup(), edge.pair.t_i_s);
    pair_edges.push_back(edge);
  });
}

double FlightNetwork::BiasChange() const {
  double change = 0.0;
  for (std::size_t e = 0; e < inertial_edges.size(); ++e) {
    const double t_s = node_t_s_[inertial_edges[e].node_i];
    const Eigen::Vector3d gyro = GyroBias(t_s) - linearised_gyro_bias_[e];
    const Eigen::Vector3d accel = AccelBias(t_s) - linearised_accel_bias_[e];
    change = std::max({change, gyro.cwiseAbs().maxCoeff() / kGyroStepRadps,
                       accel.cwiseAbs().maxCoeff() / kAccelStepMps2});
  }
  const CalibrationState now = Calibration();
  for (std::size_t k = 0; k < now.effects.size(); ++k) {
    change = std::max(change,
                      InTypicalSizes(linearised_.effects[k], now.effects[k].value) / kEffectStep);
  }
  return change;
}

FactorId FlightNetwork::AddEdge(std::shared_ptr<const FactorBase> factor,
                                const std::vector<BlockId>& blocks, const FactorGroup& group,
                                double t_s) {
  const std::weak_ptr<const FactorBase> made = factor;
  const FactorId id = net.AddFactor(std::move(factor), blocks);
  net.Tag(id, group, t_s);
  made_[id] = made;
  return id;
}

template <class Make>
void FlightNetwork::Renew(FactorId id, const Make& make) {
  std::weak_ptr<const FactorBase>& made = made_[id];
  if (made.lock() != net.factor(id).factor) return;
  std::shared_ptr<const FactorBase> factor = make();
  made = factor;
  net.ReplaceFactor(id, std::move(factor));
}

void FlightNetwork::Repreintegrate() {
  linearised_ = Calibration();
  for (std::size_t e = 0; e < inertial_edges.size(); ++e) {
    const double t_s = node_t_s_[inertial_edges[e].node_i];
    linearised_gyro_bias_[e] = GyroBias(t_s);
    linearised_accel_bias_[e] = AccelBias(t_s);
  }
  const auto inertial = InertialFactors(linearised_);
  for (std::size_t e = 0; e < inertial_edges.size(); ++e) {
    Renew(inertial_edges[e].id, [&] { return inertial[e]; });
  }
  const bool with_effects = !GnssEffectIndices(linearised_).empty();
  for (const GnssEdge& edge : gnss_edges) {
    if (with_effects) {
      Renew(edge.position, [&] { return GnssPositionFactor(edge, linearised_); });
    }
    if (edge.velocity >= 0) {
      Renew(edge.velocity, [&] { return GnssVelocityFactor(edge, linearised_); });
    }
  }
  ForPairs(pair_edges, linearised_,
           [&](const PairEdge& edge, const auto& make) { Renew(edge.id, make); });
}

FlightNetwork::StateBetween FlightNetwork::StateAt(double t_s) const {
  constexpr double kSameNodeS = 1e-7;
  if (t_s < node_t_s_.front() - kSameNodeS || t_s > node_t_s_.back() + kSameNodeS) {
    throw InvalidInput("flight network: t = " + std::to_string(t_s) + " s is outside its nodes, " +
                       std::to_string(node_t_s_.front()) + " to " +
                       std::to_string(node_t_s_.back()) + " s");
  }
  const std::size_t k = NodeBefore(node_t_s_, t_s + kSameNodeS);
  const ImuCorrection correction =
      Calibration().ImuAt(GyroBias(node_t_s_[k]), AccelBias(node_t_s_[k]));
  const Preintegrated increments =
      t_s - node_t_s_[k] > kSameNodeS
          ? Preintegrate(*flight_->imu, node_t_s_[k], t_s, correction, noise_)
          : IdentityIncrement(*flight_->imu, node_t_s_[k], correction);
  return {k, StateAfterNode(flight_->frame, increments, NodePose(k).p_mb), increments};
}

std::vector<BlockId> FlightNetwork::StateBlocks(std::size_t k) const {
  std::vector<BlockId> blocks{nodes[k].q_mb.id, nodes[k].p_mb.id, nodes[k].v_m.id};
  for (const ProcessChain& chain : gyro_bias) blocks.push_back(chain.At(node_t_s_[k]).id);
  for (const ProcessChain& chain : accel_bias) blocks.push_back(chain.At(node_t_s_[k]).id);
  return blocks;
}

std::vector<const double*> FlightNetwork::PairValues(std::size_t k) const {
  std::vector<const double*> x;
  for (const BlockId id : net.factor(pair_edges[k].id).blocks) {
    x.push_back(net.block(id).value.get());
  }
  return x;
}

PointSensitivity FlightNetwork::EndSensitivity(const PairEndIndex& end) const {
  const PairEdge& edge = pair_edges[end.k];
  const std::vector<const double*> x = PairValues(end.k);
  const auto by = [&](const FactorBase& factor) -> std::optional<PointSensitivity> {
    const auto* points = dynamic_cast<const PointPairFactor*>(&factor);
    if (points == nullptr) return std::nullopt;
    return points->SensitivityAt(end.end, x.data());
  };
  if (const auto point = by(*net.factor(edge.id).factor)) return *point;
  // The blocks of a user-defined factor come after the blocks of the library's factor.
  const CalibrationState calibration = Calibration();
  const PairCalibration of_pair(calibration);
  return *by(*PairFactor(edge, of_pair, IntegratePairIncrements({&edge, 1}, of_pair).front()));
}

Eigen::Vector3d FlightNetwork::PairDifference(std::size_t k) const {
  const FactorRecord& record = net.factor(pair_edges[k].id);
  const std::vector<const double*> x = PairValues(k);
  const auto* points = dynamic_cast<const PointPairFactor*>(record.factor.get());
  if (points == nullptr) {
    throw InvalidInput("flight network: the replacement of the pair factor at t = " +
                       std::to_string(pair_edges[k].pair.t_i_s) +
                       " s is not a PointPairFactor; derive its class from PointPairFactor");
  }
  const auto [x_i, x_j] = points->Points(x.data());
  return x_i - x_j;
}

}  // namespace dn
