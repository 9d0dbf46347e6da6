#include <dn/axis_names.h>
#include <dn/builder/control_edges.h>
#include <dn/builder/gravitation_jacobians.h>
#include <dn/builder/node_grid.h>
#include <dn/factors/prior.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "append.h"
#include "factor_groups.h"

namespace dn {
namespace {

using Directions = Eigen::Matrix<double, 3, Eigen::Dynamic>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// Returns the normal of the surface that a return observes; nullopt if it observes a point.
std::optional<Eigen::Vector3d> Normal(const ControlPoint& point, const ControlReturn& one) {
  if (point.plane) return point.plane->normal_m;
  return one.normal_m;
}

/// Returns the directions in which the returns determine a point. For a plane it is the normal; for
/// a point it is the vertical if all returns are on the surface around it, else all three.
Directions DeterminedDirections(const LocalFrame& frame, const ControlPoint& point) {
  if (point.plane) return point.plane->normal_m;
  const bool surfaces = std::all_of(point.returns.begin(), point.returns.end(),
                                    [](const ControlReturn& one) { return one.normal_m; });
  if (surfaces && !point.is_corner) return frame.R_m_enu(point.p_m).col(2);
  return Eigen::Matrix3d::Identity();
}

/// Returns the first word of the names of the unknowns.
std::string KindWord(ControlEdges::Kind kind) {
  switch (kind) {
    case ControlEdges::Kind::kControl:
      return "control";
    case ControlEdges::Kind::kTies:
      return "tie";
    case ControlEdges::Kind::kSurfaces:
      return "surface";
  }
  return "control";
}

double SurveySigma(const ControlPoint& point, const Eigen::Vector3d& direction) {
  return point.plane ? point.plane->sigma_m
                     : std::sqrt(direction.dot(point.covariance_m2 * direction));
}

/// Returns the square root of the information of a return. `covariance_m2` is that of its point.
Rows SqrtInformation(const ControlPoint& point, const ControlReturn& one,
                     const Eigen::Matrix3d& covariance_m2) {
  if (const auto normal = Normal(point, one)) {
    return normal->transpose() / std::sqrt(normal->dot(covariance_m2 * *normal));
  }
  return Noise<3>::Covariance(covariance_m2).sqrt_information();
}

}  // namespace

void ControlEdges::Add(const ControlData& control) {
  control_ = &control;
  const std::optional<ControlConfig>& config = context_.flight.config.control;
  if (kind_ == Kind::kControl && !datum_shift_ && config && config->datum_shift_sigma_m)
    AddDatumShift();
  const double margin_s = context_.calibration.MovesLidarEpochs() ? kLidarTimeMarginS : -1e-7;
  const CalibrationState calibration = context_.calibration.State();
  for (std::size_t k = 0; k < control.points.size(); ++k) {
    const bool added = std::any_of(points_.begin(), points_.end(),
                                   [&](const ControlNode& node) { return node.point == k; });
    if (!added) AddPoint(k, margin_s, calibration);
  }
}

void ControlEdges::AddDatumShift() {
  datum_shift_ = net_.AddVector<3>("control_datum_shift", Eigen::Vector3d::Zero());
  net_.SetLabel(datum_shift_->id, {"datum shift of the control", AxisNames(kEnu), "m", 1.0});
  const FactorId id = net_.Add(
      PriorVector<3>(Eigen::Vector3d::Zero(),
                     Noise<3>::Sigma(*context_.flight.config.control->datum_shift_sigma_m)),
      *datum_shift_);
  net_.Tag(id, builder_internal::PriorGroup(), std::numeric_limits<double>::quiet_NaN());
}

void ControlEdges::AddPoint(std::size_t index, double margin_s,
                            const CalibrationState& calibration) {
  const ControlPoint& point = control_->points[index];
  std::vector<ControlEdge> found;
  for (std::size_t k = 0; k < point.returns.size(); ++k) {
    if (const auto edge = Attach(index, k, margin_s)) found.push_back(*edge);
  }
  if (found.size() < (kind_ == Kind::kSurfaces ? 2U : 1U)) return;
  ControlNode node;
  node.point = index;
  node.directions = DeterminedDirections(context_.flight.frame, point);
  AddDeviation(point, &node);
  if (kind_ == Kind::kControl) AddSurvey(point, &node);
  const std::vector<BlockId> effects =
      context_.calibration.EffectIds(PairEffectIndices(calibration));
  points_.push_back(node);
  for (ControlEdge& edge : found) {
    std::vector<BlockId> blocks = Blocks(edge, node.deviation);
    builder_internal::Append(effects, &blocks);
    const ControlReturn& one = point.returns[edge.return_of];
    edge.id = context_.factors.Add(Factor(edge, calibration, BridgeInUse(edge)), blocks,
                                   ReturnGroup(point, one), one.t_s);
    points_.back().edges.push_back(edges_.size());
    edges_.push_back(edge);
  }
  if (kind_ != Kind::kControl) MoveToReturn(points_.back());
}

void ControlEdges::AddDeviation(const ControlPoint& point, ControlNode* node) {
  const std::string kind = KindWord(kind_);
  const double t_s = point.returns.front().t_s;
  if (node->directions.cols() == 1) {
    node->deviation =
        net_.AddVector<1>(kind + "/" + point.name, Eigen::Matrix<double, 1, 1>::Zero()).id;
    net_.SetLabel(node->deviation, {kind + " " + point.name, {"normal"}, "m", 1.0, t_s});
  } else {
    node->deviation = net_.AddVector<3>(kind + "/" + point.name, Eigen::Vector3d::Zero()).id;
    net_.SetLabel(node->deviation, {kind + " " + point.name, AxisNames(kEnu), "m", 1.0, t_s});
  }
}

void ControlEdges::AddSurvey(const ControlPoint& point, ControlNode* node) {
  const bool plane = node->directions.cols() == 1;
  if (plane) {
    const double sigma_m = SurveySigma(point, node->directions.col(0));
    node->survey =
        net_.Add(PriorVector<1>(Eigen::Matrix<double, 1, 1>::Zero(), Noise<1>::Sigma(sigma_m)),
                 Block<Vec<1>>{node->deviation});
  } else {
    node->survey =
        net_.Add(PriorVector<3>(Eigen::Vector3d::Zero(), Noise<3>::Covariance(point.covariance_m2)),
                 Block<Vec<3>>{node->deviation});
  }
  net_.Tag(node->survey, builder_internal::ControlGroup(plane), point.returns.front().t_s);
  net_.SetActive(node->survey, !point.is_check);
}

/// Gives a point without survey the position of its first return at the present trajectory and
/// calibration.
void ControlEdges::MoveToReturn(const ControlNode& node) {
  const ControlEdge& edge = edges_[node.edges.front()];
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  net_.EvaluateFactor(edge.id, &r, &J);
  constexpr std::size_t kDeviation = 6;  // block of PointToControl, its Jacobian is -W E
  const Eigen::VectorXd deviation_m = -J[kDeviation].inverse() * r;
  if (deviation_m.size() == 1) {
    net_.SetValue(Block<Vec<1>>{node.deviation}, Eigen::Matrix<double, 1, 1>(deviation_m));
  } else {
    net_.SetValue(Block<Vec<3>>{node.deviation}, Eigen::Vector3d(deviation_m));
  }
}

const FactorGroup& ControlEdges::ReturnGroup(const ControlPoint& point,
                                             const ControlReturn& one) const {
  if (kind_ == Kind::kTies) return builder_internal::TiePointGroup();
  if (kind_ == Kind::kSurfaces) return builder_internal::SurfaceGroup();
  return builder_internal::ControlReturnGroup(Normal(point, one).has_value(), !point.is_check);
}

std::optional<ControlEdge> ControlEdges::Attach(std::size_t point, std::size_t return_of,
                                                double margin_s) const {
  const std::vector<double>& node_t_s = context_.trajectory.node_times();
  const ControlReturn& one = control_->points[point].returns[return_of];
  const bool outside = one.t_s - margin_s < node_t_s.front() || one.t_s > node_t_s.back() + 1.0;
  if (outside) return std::nullopt;
  ControlEdge edge{point, return_of, NodeBefore(node_t_s, one.t_s - margin_s)};
  if (HasGap(*context_.flight.imu, node_t_s[edge.node], one.t_s)) return std::nullopt;
  edge.bridge = inertial_.FindEdge(edge.node);
  return edge;
}

std::shared_ptr<const PreintegratedInertial> ControlEdges::BridgeInUse(
    const ControlEdge& edge) const {
  return edge.bridge ? inertial_.FactorInUse(inertial_.edges()[*edge.bridge]) : nullptr;
}

std::vector<BlockId> ControlEdges::Blocks(const ControlEdge& edge, BlockId deviation) const {
  const CalibrationBlocks& calibration = context_.calibration;
  std::vector<BlockId> blocks = context_.trajectory.NodeIds(edge.node);
  builder_internal::Append({calibration.boresight().id, calibration.lidar_lever_arm().id,
                            calibration.lidar_time_offset().id, deviation},
                           &blocks);
  if (datum_shift_) blocks.push_back(datum_shift_->id);
  if (edge.bridge) blocks.push_back(context_.trajectory.nodes()[edge.node + 1].q_mb.id);
  return blocks;
}

std::shared_ptr<const FactorBase> ControlEdges::Factor(
    const ControlEdge& edge, const CalibrationState& calibration,
    const std::shared_ptr<const PreintegratedInertial>& bridge) const {
  const Flight& flight = context_.flight;
  const ControlPoint& point = control_->points[edge.point];
  const ControlReturn& one = point.returns[edge.return_of];
  const PairCalibration prepared(calibration);
  const double node_t_s = context_.trajectory.node_times()[edge.node];
  EndIncrements increments(*flight.imu, calibration, context_.noise, node_t_s,
                           context_.trajectory.BiasesAt(node_t_s));
  const double epoch_s = prepared.EmissionTime(prepared.Read({one.t_s, one.u_s}));
  const double sigma_m = one.sigma_m.value_or(LaserSigma(flight.config));
  Eigen::Matrix3d covariance_m2 = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  PreparedControl control;
  control.end = PrepareEnd(
      flight, prepared, {one.t_s, one.u_s},
      {context_.trajectory.NodePose(edge.node), increments.To(epoch_s), bridge}, &covariance_m2);
  control.R_bs_nominal = flight.config.lidar->mounting.R_bs_nominal;
  control.z_m = point.p_m;
  control.directions = DeterminedDirections(flight.frame, point);
  control.sqrt_information =
      SqrtInformation(point, one, 0.5 * (covariance_m2 + covariance_m2.transpose()));
  control.with_datum_shift = datum_shift_.has_value();
  return std::make_shared<PointToControl>(
      flight.frame, control, prepared.lidar(),
      GravitationJacobians(calibration, control.end.p_nominal_m));
}

void ControlEdges::Repreintegrate(const CalibrationState& calibration) {
  for (const ControlEdge& edge : edges_) {
    context_.factors.Renew(edge.id, [&] { return Factor(edge, calibration, BridgeInUse(edge)); });
  }
}

}  // namespace dn
