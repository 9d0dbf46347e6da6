#include <dn/axis_names.h>
#include <dn/builder/gnss_factors.h>
#include <dn/builder/gnss_multipath.h>
#include <dn/builder/node_grid.h>
#include <dn/builder/trajectory_graph.h>
#include <dn/error.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "factor_groups.h"

namespace dn {
namespace {

/// Adds one chain per process of a sensor; the first process has the whole initial value.
std::vector<ProcessChain> AddBiasChains(const SensorNoise& sensor,
                                        const std::vector<std::vector<ConstantInterval>>& intervals,
                                        ChainNames names, const Eigen::Vector3d& initial,
                                        const ProcessModel& model, Network* net) {
  const std::string triad = names.name;
  std::vector<ProcessChain> chains;
  for (std::size_t k = 0; k < sensor.processes.size(); ++k) {
    names.name = triad + std::to_string(k);
    const Eigen::Vector3d start = k == 0 ? initial : Eigen::Vector3d::Zero();
    chains.push_back(AddProcessChain(sensor.processes[k], intervals[k], names, start, net, model));
  }
  return chains;
}

}  // namespace

TrajectoryGraph::TrajectoryGraph(const Flight& flight, const std::vector<double>& node_t_s,
                                 const InitialStates& initial, const ChainOptions& options,
                                 Network* net)
    : flight_(flight), net_(*net), node_t_s_(node_t_s) {
  AddNodes(initial.nodes);
  AddBiases(initial, options);
  AddGnssErrors(options);
}

void TrajectoryGraph::AddNodes(const std::vector<MapPose>& poses) {
  if (poses.size() != node_t_s_.size()) {
    throw InvalidInput("flight network: " + std::to_string(poses.size()) + " starting poses for " +
                       std::to_string(node_t_s_.size()) + " nodes");
  }
  nodes_.reserve(node_t_s_.size());
  for (std::size_t k = 0; k < node_t_s_.size(); ++k) {
    const std::string suffix = "/" + std::to_string(k);
    NodeBlocks node;
    node.t_s = node_t_s_[k];
    node.q_mb = net_.AddRotation("q_mb" + suffix, poses[k].q_mb);
    node.p_mb = net_.AddVector<3>("p_mb" + suffix, poses[k].p_mb);
    node.v_m = net_.AddVector<3>("v_m" + suffix, poses[k].v_m);
    net_.SetLabel(node.q_mb.id, {"attitude",
                                 {"about body x", "about body y", "about body z"},
                                 "deg",
                                 kDegPerRad,
                                 node.t_s});
    net_.SetLabel(node.p_mb.id, {"position", AxisNames(kEnu), "m", 1.0, node.t_s});
    net_.SetLabel(node.v_m.id, {"velocity", AxisNames(kEnu), "m/s", 1.0, node.t_s});
    nodes_.push_back(node);
  }
}

double TrajectoryGraph::ConstantIntervalLength(const BiasProcess& process,
                                               const ChainOptions& options) const {
  switch (process.type) {
    case BiasProcess::Type::kGaussMarkov:
      return std::min(process.tau_s * options.interval_per_tau, options.interval_max_s);
    case BiasProcess::Type::kRandomWalk:
      return options.interval_max_s;
    case BiasProcess::Type::kRandomConstant:
      break;
  }
  return node_t_s_.back() - node_t_s_.front();
}

void TrajectoryGraph::AddBiases(const InitialStates& initial, const ChainOptions& options) {
  const ImuModel& model = flight_.config.imu->model;
  const auto intervals = [&](const SensorNoise& sensor) {
    std::vector<std::vector<ConstantInterval>> out;
    for (const BiasProcess& process : sensor.processes) {
      out.push_back(IntervalsOverNodes(node_t_s_, ConstantIntervalLength(process, options)));
    }
    return out;
  };
  const FactorGroup& prior = builder_internal::PriorGroup();
  gyro_bias_ = AddBiasChains(model.gyro, intervals(model.gyro),
                             {"gyro_bias/", "gyro bias", AxisNames(kXyz), "deg/h",
                              kDegPerRad * 3600.0, builder_internal::BiasProcessGroup(true), prior},
                             initial.gyro_bias_radps, options.model, &net_);
  accel_bias_ =
      AddBiasChains(model.accel, intervals(model.accel),
                    {"accel_bias/", "accelerometer bias", AxisNames(kXyz), "mg",
                     1e3 / kStandardGravityMps2, builder_internal::BiasProcessGroup(false), prior},
                    initial.accel_bias_mps2, options.model, &net_);
}

void TrajectoryGraph::AddGnssErrors(const ChainOptions& options) {
  if (!flight_.gnss) return;
  const GnssConfig& config = *flight_.config.gnss;
  const TimeInterval span{node_t_s_.front() - kOnNodeS, node_t_s_.back() + kOnNodeS};
  std::vector<double> epoch_t_s;
  Eigen::Array3d least_variance = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
  for (const MapGnssEpoch& epoch : flight_.gnss->epochs) {
    if (epoch.t_s < span.t0_s || epoch.t_s > span.t1_s) continue;
    epoch_t_s.push_back(epoch.t_s);
    least_variance = least_variance.min(GnssPositionCovariance(epoch, config).diagonal().array());
  }
  if (epoch_t_s.empty()) return;
  for (const BiasProcess& process : GnssProcessesInSigmas(config)) {
    const std::size_t i = gnss_error_.size();
    const double white_share =
        (least_variance / config.processes[i].sigma_enu_m.array().square()).minCoeff();
    const double length_s = ConstantIntervalLength(process, options) * std::min(1.0, white_share);
    gnss_error_.push_back(
        AddProcessChain(process, IntervalsOverEpochs(epoch_t_s, length_s),
                        {"gnss_error/" + std::to_string(i), "GNSS error", AxisNames(kEnu), "sigma",
                         1.0, builder_internal::GnssErrorGroup(), builder_internal::PriorGroup()},
                        Eigen::Vector3d::Zero(), &net_, options.model));
  }
}

MapPose TrajectoryGraph::NodePose(std::size_t k) const {
  const NodeBlocks& node = nodes_[k];
  return {node.t_s, net_.Value(node.q_mb), net_.Value(node.p_mb), net_.Value(node.v_m)};
}

std::vector<MapPose> TrajectoryGraph::NodePoses() const {
  std::vector<MapPose> poses;
  for (std::size_t k = 0; k < nodes_.size(); ++k) poses.push_back(NodePose(k));
  return poses;
}

Eigen::Vector3d TrajectoryGraph::GyroBias(double t_s) const {
  return SumProcesses(net_, gyro_bias_, t_s);
}

Eigen::Vector3d TrajectoryGraph::AccelBias(double t_s) const {
  return SumProcesses(net_, accel_bias_, t_s);
}

ImuCorrection TrajectoryGraph::BiasesAt(double t_s) const {
  return {GyroBias(t_s), AccelBias(t_s)};
}

Eigen::Vector3d TrajectoryGraph::GnssErrorEnu(double t_s) const {
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < gnss_error_.size(); ++i) {
    sum_m += GnssErrorSigmaEnu(i, t_s).cwiseProduct(net_.Value(gnss_error_[i].At(t_s)));
  }
  return sum_m;
}

Eigen::Vector3d TrajectoryGraph::GnssErrorSigmaEnu(std::size_t i, double t_s) const {
  const MapPose pose = NodePose(NodeNear(node_t_s_, t_s));
  return GnssProcessSigma(flight_.config.gnss->processes[i], pose,
                          flight_.frame.R_m_enu(pose.p_mb).col(2));
}

std::vector<BlockId> TrajectoryGraph::NodeIds(std::size_t k) const {
  return {nodes_[k].q_mb.id, nodes_[k].p_mb.id, nodes_[k].v_m.id};
}

std::vector<BlockId> TrajectoryGraph::BiasIds(std::size_t k) const {
  std::vector<BlockId> ids;
  for (const ProcessChain& chain : gyro_bias_) ids.push_back(chain.At(node_t_s_[k]).id);
  for (const ProcessChain& chain : accel_bias_) ids.push_back(chain.At(node_t_s_[k]).id);
  return ids;
}

}  // namespace dn
