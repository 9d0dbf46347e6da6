#include <dn/builder/node_grid.h>
#include <dn/diagnosis/solution.h>
#include <dn/effects/effect_table.h>
#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "competing_effects.h"
#include "gnss_process.h"
#include "network_hypotheses.h"
#include "unmodelled.h"

namespace dn {
namespace {

/// Adds the changes by the effects that the model leaves out.
void AddChanges(const std::vector<UnmodelledEffects::UnknownChange>& changes,
                std::vector<BeamCorrections>* all) {
  for (BeamCorrections& beams : *all) {
    const auto change = std::find_if(changes.begin(), changes.end(), [&](const auto& one) {
      return one.name == beams.unknown.name;
    });
    if (change != changes.end()) beams.AddChange(change->value, change->variance);
  }
}

void AddVariance(const Eigen::Vector3d& variance, Eigen::Vector3d* sigma) {
  *sigma = (sigma->cwiseAbs2() + variance).cwiseSqrt();
}

}  // namespace

Solution::Solution(const Flight& flight, const AdjustOptions& options)
    : Solution(Adjust(flight, options), options.threads) {}

Solution::Solution(Adjustment adjustment, int threads)
    : adjustment_(std::move(adjustment)),
      threads_(threads),
      marginals_(adjustment_.network->net(),
                 {.threads = threads, .analysis = std::move(adjustment_.analysis)}) {
  marginals_.ComputeSelectedInverse();
}

Adjustment Solution::TakeAdjustment() {
  Adjustment adjustment = std::move(adjustment_);
  adjustment.analysis = std::make_shared<SharedAnalysis>();
  return adjustment;
}

const TrajectoryResult& Solution::trajectory() const {
  if (!trajectory_) trajectory_ = ExtractTrajectory(adjustment_, marginals_);
  return *trajectory_;
}

const ModelCheck& Solution::model_check() const {
  if (!model_check_) model_check_ = CheckModel(adjustment_, marginals_, trajectory(), threads_);
  return *model_check_;
}

BoresightResult Solution::Boresight() const { return ExtractBoresight(adjustment_, marginals_); }

BoresightResult Solution::CheckedBoresight() const {
  BoresightResult boresight = Boresight();
  Assess(model_check(), &boresight);
  return boresight;
}

std::optional<UnmodelledEffects> Solution::PredictEffects() const {
  const FlightConfig& config = network().flight().config;
  const UnmodelledPrior prior = MakeUnmodelledPrior(config);
  if (prior.pure() && !HasAutomaticGnssProcess(config)) return std::nullopt;
  diagnosis_internal::Library library =
      diagnosis_internal::MakeNetworkHypotheses(network(), threads_, {});
  const auto process =
      diagnosis_internal::AddGnssProcess(network(), marginals_.linearized(), &library);
  std::vector<BlockId> watched{network().calibration().boresight().id};
  const std::vector<BlockId> beams = diagnosis_internal::BeamBlocks(network());
  watched.insert(watched.end(), beams.begin(), beams.end());
  const std::vector<BlockId> mountings = MountingUnknowns(network());
  watched.insert(watched.end(), mountings.begin(), mountings.end());
  JointScore score = ScoreEffects(marginals_, library.blocks, watched);
  score.s.setZero();
  const diagnosis_internal::UnmodelledUnknowns unknowns(library, prior, score, process,
                                                        diagnosis_internal::SizeSource::kPrior);
  if (unknowns.empty()) return std::nullopt;
  const Eigen::MatrixXd added = unknowns.AddedCovariance();
  UnmodelledEffects effects;
  effects.covariance_rad2 = added.topLeftCorner<3, 3>();
  effects.contributions = unknowns.Contributions({0});
  Eigen::Index row = 3;
  for (const BlockId beam : beams) {
    const BlockRecord& block = network().net().block(beam);
    const Eigen::Index values = block.kind.tangent_size;
    effects.unknowns.push_back(
        {block.name, Eigen::VectorXd::Zero(values), added.diagonal().segment(row, values)});
    row += values;
  }
  const auto size = 3 * static_cast<Eigen::Index>(mountings.size());
  effects.mountings_covariance = added.bottomRightCorner(size, size);
  return effects;
}

BoresightResult Solution::PredictedBoresight() const {
  BoresightResult boresight = Boresight();
  if (const auto effects = PredictEffects()) AddUnmodelled(*effects, &boresight);
  return boresight;
}

ScannerMountings Solution::CheckedMountings() const {
  return ExtractMountings(adjustment_, marginals_, &model_check());
}

ScannerMountings Solution::PredictedMountings() const {
  if (MountingUnknowns(network()).empty()) return {};
  return PredictMountings(adjustment_, marginals_, PredictEffects().value_or(UnmodelledEffects()));
}

std::vector<BeamCorrections> Solution::CheckedBeams() const {
  std::vector<BeamCorrections> beams = ExtractBeams(adjustment_, marginals_);
  if (model_check().unmodelled) AddChanges(model_check().unmodelled->unknowns, &beams);
  return beams;
}

std::vector<BeamCorrections> Solution::PredictedBeams() const {
  std::vector<BeamCorrections> beams = ExtractBeams(adjustment_, marginals_);
  if (beams.empty()) return beams;
  if (const auto effects = PredictEffects()) AddChanges(effects->unknowns, &beams);
  return beams;
}

std::vector<UnknownEstimate> Solution::Unknowns() const {
  return ExtractUnknowns(adjustment_, marginals_);
}

std::vector<UnknownEstimate> Solution::CheckedUnknowns() const {
  std::vector<UnknownEstimate> unknowns = Unknowns();
  if (!model_check().unmodelled) return unknowns;
  for (const UnmodelledEffects::UnknownChange& change : model_check().unmodelled->unknowns) {
    const auto at = std::find_if(unknowns.begin(), unknowns.end(),
                                 [&](const auto& unknown) { return unknown.name == change.name; });
    if (at == unknowns.end()) continue;
    const double per_si = 1.0 / EffectRow(FindEffect(change.name)->id).components.front().to_si;
    for (std::size_t k = 0; k < at->value.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      at->value[k] += per_si * change.value[row];
      at->sigma[k] = std::hypot(at->sigma[k], per_si * std::sqrt(change.variance[row]));
    }
  }
  return unknowns;
}

std::vector<MapPose> Solution::CheckedPoses() const {
  std::vector<MapPose> poses = network().trajectory().NodePoses();
  if (!model_check().unmodelled) return poses;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    model_check().unmodelled->nodes[k].MovePose(&poses[k]);
  }
  return poses;
}

std::vector<BiasEstimate> Solution::CheckedBiases() const {
  std::vector<BiasEstimate> biases = trajectory().biases;
  if (!model_check().unmodelled) return biases;
  for (std::size_t k = 0; k < biases.size(); ++k) {
    const NodeChange& change = model_check().unmodelled->nodes[k];
    biases[k].gyro_radps += change.gyro_bias_radps;
    biases[k].accel_mps2 += change.accel_bias_mps2;
    AddVariance(change.gyro_bias_covariance.diagonal(), &biases[k].sigma_gyro_radps);
    AddVariance(change.accel_bias_covariance.diagonal(), &biases[k].sigma_accel_mps2);
  }
  return biases;
}

std::vector<TrajectorySigma> Solution::CheckedSigmas() const {
  std::vector<TrajectorySigma> sigma = trajectory().sigma;
  if (!model_check().unmodelled) return sigma;
  for (std::size_t k = 0; k < sigma.size(); ++k) {
    const NodeChange& change = model_check().unmodelled->nodes[k];
    AddVariance(change.pose_root.topRows<3>().rowwise().squaredNorm(), &sigma[k].position_enu_m);
    AddVariance(change.velocity_variance_enu, &sigma[k].velocity_enu_mps);
    AddVariance(change.rph_variance_rad2, &sigma[k].rph_rad);
  }
  return sigma;
}

std::vector<NavPoint> Solution::CheckedTrajectory(std::vector<NavPoint> points) const {
  if (!model_check().unmodelled) return points;
  const std::vector<NodeChange>& nodes = model_check().unmodelled->nodes;
  const LocalFrame& frame = network().flight().frame;
  std::size_t after = 1;
  for (NavPoint& point : points) {
    while (after + 1 < nodes.size() && nodes[after].t_s < point.t_s) ++after;
    const NodeChange& a = nodes[after - 1];
    const NodeChange& b = nodes[after];
    const double share = std::clamp((point.t_s - a.t_s) / (b.t_s - a.t_s), 0.0, 1.0);
    const auto between = [&](Eigen::Vector3d NodeChange::*part) {
      return Eigen::Vector3d((1.0 - share) * a.*part + share * b.*part);
    };
    NodeChange change;
    change.position_m = between(&NodeChange::position_m);
    change.velocity_mps = between(&NodeChange::velocity_mps);
    change.attitude_rad = between(&NodeChange::attitude_rad);
    MapPose pose = ToMapPose(point, frame);
    change.MovePose(&pose);
    const NavPoint moved = ToNavPoint(pose, frame);
    point.position = moved.position;
    point.q_nb = moved.q_nb;
    point.v_ned_mps = moved.v_ned_mps;
  }
  return points;
}

TrajectoryCovariance Solution::PoseCovariance(const std::vector<StripInterval>& strips) const {
  TrajectoryCovariance poses = ExtractTrajectoryCovariance(adjustment_, marginals_, strips);
  if (!model_check().unmodelled || poses.t_s.empty()) return poses;
  Eigen::MatrixXd root(poses.covariance.rows(),
                       model_check().unmodelled->nodes.front().pose_root.cols());
  for (std::size_t k = 0; k < poses.t_s.size(); ++k) {
    const std::size_t node = NodeNear(network().trajectory().node_times(), poses.t_s[k]);
    root.middleRows<6>(6 * static_cast<Eigen::Index>(k)) =
        model_check().unmodelled->nodes[node].pose_root;
  }
  poses.covariance += root * root.transpose();
  return poses;
}

}  // namespace dn
