#include <dn/builder/estimable.h>
#include <dn/builder/flight_network.h>
#include <dn/builder/measurement_noise.h>
#include <dn/factors/bias_process.h>
#include <dn/factors/gnss_position.h>
#include <dn/factors/gnss_velocity.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/preintegrated_inertial.h>
#include <dn/factors/prior.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dn {

using internal::MeasurementNoise;

namespace {

constexpr const char* kCheckGnss = "check its sigmas and gnss.sigma_scale";

constexpr double kPpm = 1e-6;
// With the time offset of the lidar free, pairs attach to a node at least this far before their
// time tag.
constexpr double kTimeOffsetMarginS = 0.05;
// One bias step beyond which the first-order bias correction of an increment is worth replacing.
constexpr double kGyroStepRadps = 30.0 / kDegPerRad / 3600.0;
constexpr double kAccelStepMps2 = 5e-3 * kStandardGravityMps2;

Eigen::Vector3d Sum(const Network& net, const std::vector<BiasChain>& chains, double t_s) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const BiasChain& chain : chains) sum += net.Value(chain.At(t_s));
  return sum;
}

BlockLabel Label(const std::string& quantity, std::vector<std::string> components,
                 const std::string& unit, double per_si,
                 double t_s = std::numeric_limits<double>::quiet_NaN()) {
  return {quantity, std::move(components), unit, per_si, t_s};
}

const std::vector<std::string> kXyz{"x", "y", "z"};

}  // namespace

Block<Vec<3>> BiasChain::At(double t_s) const { return blocks[NodeBefore(t_begin_s, t_s)]; }

Eigen::Matrix3d GnssPositionCovariance(const GnssEpoch& epoch, const GnssConfig& config,
                                       const LocalFrame& frame) {
  const Eigen::Matrix3d covariance_enu = epoch.covariance_enu_m2.value_or(
      Eigen::Matrix3d(config.sigma_enu_m.cwiseAbs2().asDiagonal()));
  const Eigen::Matrix3d R_m_enu = frame.R_m_enu(frame.ToMap(epoch.antenna));
  return config.sigma_scale * config.sigma_scale * R_m_enu * covariance_enu * R_m_enu.transpose();
}

GnssVelocity MakeGnssVelocity(const GnssEpoch& epoch, const GnssConfig& config,
                              const LocalFrame& frame, const Eigen::Vector3d& w_ib_b_radps,
                              const Eigen::Matrix3d& added_covariance) {
  const Eigen::Matrix3d R_m_enu = frame.R_m_enu(frame.ToMap(epoch.antenna));
  const Eigen::Matrix3d covariance = config.sigma_scale * config.sigma_scale * R_m_enu *
                                     *epoch.velocity_covariance_enu * R_m_enu.transpose();
  return {
      R_m_enu * *epoch.velocity_enu_mps, w_ib_b_radps, frame.w_ie_m(),
      MeasurementNoise(covariance + added_covariance, "the GNSS velocity", epoch.t_s, kCheckGnss)};
}

bool UsesVelocity(const GnssEpoch& epoch, const GnssConfig& config) {
  return config.use_velocity.value_or(true) && epoch.velocity_enu_mps.has_value() &&
         epoch.velocity_covariance_enu.has_value();
}

FlightNetwork::FlightNetwork(const Flight& flight, const std::vector<double>& node_t_s,
                             const InitialStates& initial, const FlightNetworkOptions& options)
    : flight_(&flight), node_t_s_(node_t_s), options_(options) {
  CheckEstimable(flight.config.estimate);
  const ImuModel& model = flight.config.imu->model;
  noise_ = {model.gyro.white, model.accel.white, options.position_floor_m};
  AddMounting();
  AddNodes(initial);
  AddBiases(initial);
  AddInertialEdges();
  AddGnssEdges();
}

bool FlightNetwork::Estimated(const std::string& unknown) const {
  const auto& estimate = flight_->config.estimate;
  return std::any_of(estimate.begin(), estimate.end(),
                     [&](const EstimateEntry& entry) { return entry.unknown == unknown; });
}

void FlightNetwork::AddMounting() {
  const FlightConfig& config = flight_->config;
  const Mounting mounting = config.lidar ? config.lidar->mounting : Mounting{};
  const Eigen::Vector3d antenna_b_m =
      config.gnss ? config.gnss->lever_arm_b_m : Eigen::Vector3d(Eigen::Vector3d::Zero());
  boresight = net.AddLeftRotation("boresight", Exp(mounting.boresight_rad));
  gnss_lever_arm = net.AddVector<3>("gnss_lever_arm", antenna_b_m);
  lidar_lever_arm = net.AddVector<3>("lidar_lever_arm", mounting.lever_arm_b_m);
  lidar_time_offset = net.AddVector<1>("lidar_time_offset", Eigen::Matrix<double, 1, 1>::Zero());
  net.SetLabel(boresight.id, Label("boresight", {"roll", "pitch", "yaw"}, "deg", kDegPerRad));
  net.SetLabel(gnss_lever_arm.id, Label("GNSS lever arm", kXyz, "m", 1.0));
  net.SetLabel(lidar_lever_arm.id, Label("lidar lever arm", kXyz, "m", 1.0));
  net.SetLabel(lidar_time_offset.id, Label("lidar time offset", {"t"}, "s", 1.0));
  net.Hold(boresight, !config.lidar || !Estimated("boresight"));
  net.Hold(gnss_lever_arm, !Estimated("gnss_lever_arm"));
  net.Hold(lidar_lever_arm, !Estimated("lidar_lever_arm"));
  net.Hold(lidar_time_offset, !Estimated("lidar_time_offset"));
  if (Estimated("gyro_scale_factor")) {
    gyro_scale_factor =
        net.AddVector<3>("gyro_scale_factor", Eigen::Vector3d(Eigen::Vector3d::Zero()));
    net.SetLabel(gyro_scale_factor.id, Label("gyro scale factor", kXyz, "ppm", 1.0 / kPpm));
  }
  if (config.lidar && config.lidar->boresight_sigma_rad) {
    const FactorId id =
        net.Add(PriorLeftRotation(Exp(mounting.boresight_rad),
                                  Noise<3>::Sigma(*config.lidar->boresight_sigma_rad)),
                boresight);
    net.Tag(id, "prior", std::numeric_limits<double>::quiet_NaN());
  }
  for (const char* unknown :
       {"gnss_lever_arm", "lidar_lever_arm", "lidar_time_offset", "gyro_scale_factor"}) {
    AddPriorOf(unknown);
  }
}

void FlightNetwork::AddPriorOf(const std::string& unknown) {
  for (const EstimateEntry& entry : flight_->config.estimate) {
    const std::optional<Eigen::VectorXd> sigma = PriorSigma(entry);
    if (entry.unknown != unknown || !sigma) continue;
    FactorId id;
    if (unknown == "lidar_time_offset") {
      id = net.Add(PriorVector<1>(net.Value(lidar_time_offset), Noise<1>::Sigma((*sigma)[0])),
                   lidar_time_offset);
    } else {
      const Block<Vec<3>> block{net.Find(unknown)};
      id = net.Add(PriorVector<3>(net.Value(block), Noise<3>::Sigma(Eigen::Vector3d(*sigma))),
                   block);
    }
    net.Tag(id, "prior", std::numeric_limits<double>::quiet_NaN());
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

void FlightNetwork::AddBiases(const InitialStates& initial) {
  const ImuModel& model = flight_->config.imu->model;
  const auto add_all = [&](const SensorNoise& sensor, bool gyro, Eigen::Vector3d start,
                           std::vector<BiasChain>* chains) {
    for (std::size_t i = 0; i < sensor.processes.size(); ++i) {
      const std::string name = (gyro ? "gyro_bias/" : "accel_bias/") + std::to_string(i);
      AddBiasChain(sensor.processes[i], name, gyro, start, chains);
      start.setZero();  // the first process takes the whole starting value
    }
  };
  add_all(model.gyro, true, initial.gyro_bias_radps, &gyro_bias);
  add_all(model.accel, false, initial.accel_bias_mps2, &accel_bias);
}

void FlightNetwork::AddBiasChain(const BiasProcess& process, const std::string& name, bool gyro,
                                 const Eigen::Vector3d& start, std::vector<BiasChain>* chains) {
  BiasChain chain;
  chain.process = process;
  const double t_end_s = node_t_s_.back();
  double length_s = t_end_s - node_t_s_.front();
  if (process.type == BiasProcess::Type::kGaussMarkov) {
    length_s =
        std::min(process.tau_s * options_.bias_interval_per_tau, options_.bias_interval_max_s);
  } else if (process.type == BiasProcess::Type::kRandomWalk) {
    length_s = options_.bias_interval_max_s;
  }
  chain.t_begin_s.push_back(node_t_s_.front());
  for (std::size_t k = 1; k + 1 < node_t_s_.size(); ++k) {
    const bool next_too_late = node_t_s_[k + 1] > chain.t_begin_s.back() + length_s + 1e-6;
    if (process.type != BiasProcess::Type::kRandomConstant && next_too_late) {
      chain.t_begin_s.push_back(node_t_s_[k]);
    }
  }
  const std::string quantity = gyro ? "gyro bias" : "accelerometer bias";
  const double per_si = gyro ? kDegPerRad * 3600.0 : 1e3 / kStandardGravityMps2;
  for (std::size_t k = 0; k < chain.t_begin_s.size(); ++k) {
    const double t1 = k + 1 < chain.t_begin_s.size() ? chain.t_begin_s[k + 1] : t_end_s;
    chain.t_mid_s.push_back(0.5 * (chain.t_begin_s[k] + t1));
    chain.blocks.push_back(net.AddVector<3>(name + "/" + std::to_string(k), start));
    const bool constant = process.type == BiasProcess::Type::kRandomConstant;
    net.SetLabel(
        chain.blocks.back().id,
        Label(quantity + (constant ? " (constant)" : ""), kXyz, gyro ? "deg/h" : "mg", per_si,
              constant ? std::numeric_limits<double>::quiet_NaN() : chain.t_mid_s.back()));
  }
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  if (process.type == BiasProcess::Type::kRandomWalk) {
    const double first_s = std::max(chain.t_mid_s.front() - chain.t_begin_s.front(), 1e-3);
    net.Tag(net.Add(PriorVector<3>(zero, Noise<3>::Sigma(process.sigma * std::sqrt(first_s))),
                    chain.blocks.front()),
            "prior", chain.t_mid_s.front());
  } else {
    net.Tag(net.Add(PriorVector<3>(zero, Noise<3>::Sigma(process.sigma)), chain.blocks.front()),
            "prior", chain.t_mid_s.front());
  }
  for (std::size_t k = 0; k + 1 < chain.blocks.size(); ++k) {
    const double dt_s = chain.t_mid_s[k + 1] - chain.t_mid_s[k];
    const FactorId id =
        process.type == BiasProcess::Type::kGaussMarkov
            ? net.Add(GaussMarkovEdge(process.sigma, process.tau_s, dt_s), chain.blocks[k],
                      chain.blocks[k + 1])
            : net.Add(RandomWalkEdge(process.sigma, dt_s), chain.blocks[k], chain.blocks[k + 1]);
    net.Tag(id, "bias process", chain.t_mid_s[k]);
  }
  chains->push_back(std::move(chain));
}

Eigen::Vector3d FlightNetwork::GyroBias(double t_s) const { return Sum(net, gyro_bias, t_s); }
Eigen::Vector3d FlightNetwork::AccelBias(double t_s) const { return Sum(net, accel_bias, t_s); }

MapPose FlightNetwork::NodePose(std::size_t k) const {
  const NodeBlocks& node = nodes[k];
  return {node.t_s, net.Value(node.q_mb), net.Value(node.p_mb), net.Value(node.v_m)};
}

ImuCorrection FlightNetwork::CorrectionAt(double t_s) const {
  return {GyroBias(t_s), AccelBias(t_s)};
}

std::shared_ptr<const FactorBase> FlightNetwork::MakeInertialFactor(std::size_t i) const {
  const double t_s = node_t_s_[i];
  const Eigen::Vector3d scale =
      gyro_scale_free() ? net.Value(gyro_scale_factor) : Eigen::Vector3d(Eigen::Vector3d::Zero());
  const Preintegrated increment =
      Preintegrate(*flight_->imu, t_s, node_t_s_[i + 1], CorrectionAt(t_s), noise_, scale);
  return std::make_shared<PreintegratedInertial>(
      increment, flight_->frame, net.Value(nodes[i].p_mb), net.Value(nodes[i + 1].p_mb),
      static_cast<int>(gyro_bias.size()), static_cast<int>(accel_bias.size()), gyro_scale_free());
}

void FlightNetwork::AddInertialEdges() {
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    if (HasGap(*flight_->imu, node_t_s_[i], node_t_s_[i + 1])) continue;
    std::vector<BlockId> blocks{nodes[i].q_mb.id,     nodes[i].p_mb.id,     nodes[i].v_m.id,
                                nodes[i + 1].q_mb.id, nodes[i + 1].p_mb.id, nodes[i + 1].v_m.id};
    for (const BiasChain& chain : gyro_bias) blocks.push_back(chain.At(node_t_s_[i]).id);
    for (const BiasChain& chain : accel_bias) blocks.push_back(chain.At(node_t_s_[i]).id);
    if (gyro_scale_free()) blocks.push_back(gyro_scale_factor.id);
    const FactorId id = net.AddFactor(MakeInertialFactor(i), blocks);
    net.Tag(id, "inertial", node_t_s_[i]);
    inertial_edges.push_back({i, id});
    linearised_gyro_bias_.push_back(GyroBias(node_t_s_[i]));
    linearised_accel_bias_.push_back(AccelBias(node_t_s_[i]));
  }
}

std::shared_ptr<const FactorBase> FlightNetwork::MakeVelocityFactor(const GnssEdge& edge) const {
  const GnssEpoch& epoch = flight_->gnss->epochs[edge.epoch];
  const GnssConfig& config = *flight_->config.gnss;
  const Preintegrated at_epoch =
      IdentityIncrement(*flight_->imu, epoch.t_s, CorrectionAt(epoch.t_s));
  return std::make_shared<GnssVelocity>(
      MakeGnssVelocity(epoch, config, flight_->frame, at_epoch.w_end_b_radps));
}

void FlightNetwork::AddGnssEdges() {
  if (!flight_->gnss) return;
  const GnssConfig& config = *flight_->config.gnss;
  const auto& epochs = flight_->gnss->epochs;
  for (std::size_t e = 0; e < epochs.size(); ++e) {
    const GnssEpoch& epoch = epochs[e];
    const std::size_t k = NodeBefore(node_t_s_, epoch.t_s + 1e-6);
    if (std::abs(node_t_s_[k] - epoch.t_s) > 2e-6) continue;  // outside the network's span
    GnssEdge edge{k, e, -1, -1};
    const Noise<3> noise = MeasurementNoise(GnssPositionCovariance(epoch, config, flight_->frame),
                                            "the GNSS position", epoch.t_s, kCheckGnss);
    edge.position = net.Add(GnssPosition(flight_->frame.ToMap(epoch.antenna), noise), nodes[k].q_mb,
                            nodes[k].p_mb, gnss_lever_arm);
    net.Tag(edge.position, "gnss position", epoch.t_s);
    if (UsesVelocity(epoch, config)) {
      edge.velocity = net.AddFactor(MakeVelocityFactor(edge),
                                    {nodes[k].q_mb.id, nodes[k].v_m.id, gnss_lever_arm.id});
      net.Tag(edge.velocity, "gnss velocity", epoch.t_s);
    }
    gnss_edges.push_back(edge);
  }
}

std::shared_ptr<const FactorBase> FlightNetwork::MakePairFactor(const PairEdge& edge) const {
  const LidarConfig& lidar = *flight_->config.lidar;
  const double dt_nominal_s = net.Value(lidar_time_offset)[0];
  const Eigen::Vector3d lever = net.Value(lidar_lever_arm);
  const Eigen::Quaterniond q_boresight = net.Value(boresight);
  const Eigen::Vector3d scale =
      gyro_scale_free() ? net.Value(gyro_scale_factor) : Eigen::Vector3d(Eigen::Vector3d::Zero());
  const auto make_end = [&](std::size_t k, double tag_s, const Eigen::Vector3d& u_s) {
    const double t_s = tag_s - dt_nominal_s;
    if (t_s < node_t_s_[k] - 1e-7) {
      throw InvalidInput("lidar time offset: the estimate of " + std::to_string(dt_nominal_s) +
                         " s exceeds the " + std::to_string(kTimeOffsetMarginS) +
                         " s that can be estimated; correct the time tags of the pairs first");
    }
    LidarEnd end;
    end.partial =
        t_s - node_t_s_[k] > 1e-7
            ? Preintegrate(*flight_->imu, node_t_s_[k], t_s, CorrectionAt(node_t_s_[k]), noise_,
                           scale)
            : IdentityIncrement(*flight_->imu, node_t_s_[k], CorrectionAt(node_t_s_[k]), scale);
    end.u_s = u_s;
    end.p_nominal_m = net.Value(nodes[k].p_mb);
    return end;
  };
  const LidarEnd i = make_end(edge.node_i, edge.pair.t_i_s, edge.pair.u_i_s);
  const LidarEnd j = make_end(edge.node_j, edge.pair.t_j_s, edge.pair.u_j_s);
  const auto arm = [&](const Eigen::Vector3d& u_s) {
    return Eigen::Vector3d(lever + q_boresight * (lidar.mounting.R_bs_nominal * u_s));
  };
  Eigen::Matrix3d covariance = edge.pair.covariance_m2.value_or(
      Eigen::Matrix3d(lidar.sigma_p_m * lidar.sigma_p_m * Eigen::Matrix3d::Identity()));
  covariance += EndNoise(i, net.Value(nodes[edge.node_i].q_mb).toRotationMatrix(), arm(i.u_s));
  covariance += EndNoise(j, net.Value(nodes[edge.node_j].q_mb).toRotationMatrix(), arm(j.u_s));
  return std::make_shared<PointToPoint>(
      flight_->frame, i, j, lidar.mounting.R_bs_nominal, dt_nominal_s,
      MeasurementNoise(0.5 * (covariance + covariance.transpose()), "the point pair",
                       edge.pair.t_i_s,
                       "check its laser vectors and covariance, and the white noise of the IMU"));
}

void FlightNetwork::AddPairs(const std::vector<LidarPair>& pairs) {
  const double margin_s = net.block(lidar_time_offset.id).held ? -1e-7 : kTimeOffsetMarginS;
  for (const LidarPair& pair : pairs) {
    PairEdge edge;
    edge.pair = pair;
    edge.node_i = NodeBefore(node_t_s_, pair.t_i_s - margin_s);
    edge.node_j = NodeBefore(node_t_s_, pair.t_j_s - margin_s);
    if (edge.node_i == edge.node_j) {
      ++pairs_within_one_node;
      continue;
    }
    if (HasGap(*flight_->imu, node_t_s_[edge.node_i], pair.t_i_s) ||
        HasGap(*flight_->imu, node_t_s_[edge.node_j], pair.t_j_s)) {
      ++pairs_in_imu_gaps;
      continue;
    }
    const NodeBlocks& i = nodes[edge.node_i];
    const NodeBlocks& j = nodes[edge.node_j];
    edge.id = net.AddFactor(MakePairFactor(edge),
                            {i.q_mb.id, i.p_mb.id, i.v_m.id, j.q_mb.id, j.p_mb.id, j.v_m.id,
                             boresight.id, lidar_lever_arm.id, lidar_time_offset.id});
    net.Tag(edge.id, "lidar p2p", pair.t_i_s);
    pair_edges.push_back(edge);
  }
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
  return change;
}

void FlightNetwork::Relinearise() {
  for (std::size_t e = 0; e < inertial_edges.size(); ++e) {
    const InertialEdge& edge = inertial_edges[e];
    linearised_gyro_bias_[e] = GyroBias(node_t_s_[edge.node_i]);
    linearised_accel_bias_[e] = AccelBias(node_t_s_[edge.node_i]);
    net.ReplaceFactor(edge.id, MakeInertialFactor(edge.node_i));
  }
  for (const GnssEdge& edge : gnss_edges) {
    if (edge.velocity >= 0) net.ReplaceFactor(edge.velocity, MakeVelocityFactor(edge));
  }
  for (const PairEdge& edge : pair_edges) net.ReplaceFactor(edge.id, MakePairFactor(edge));
}

Eigen::Vector3d FlightNetwork::PairDifference(std::size_t k) const {
  const FactorRecord& record = net.factor(pair_edges[k].id);
  std::vector<const double*> x;
  for (const BlockId id : record.blocks) x.push_back(net.block(id).value.get());
  const auto [x_i, x_j] = static_cast<const PointToPoint&>(*record.factor).Points(x.data());
  return x_i - x_j;
}

}  // namespace dn
