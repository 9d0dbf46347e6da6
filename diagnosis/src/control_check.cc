#include "control_check.h"

#include <dn/distributions.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Returns the whitening matrix of the survey of a point.
MatrixXd SurveyWhitening(const FlightNetwork& network, const ControlNode& node) {
  VectorXd r;
  std::vector<MatrixXd> J;
  network.net().EvaluateFactor(node.survey, &r, &J);
  return J.front();
}

class Checker {
 public:
  explicit Checker(const ControlCheckInput& input)
      : input_(input),
        network_(*input.adjustment.network),
        control_(network_.control()),
        change_(input.unmodelled.Correction()),
        added_(input.unmodelled.AddedCovariance()) {}

  ControlCheck Run() {
    ControlCheck check;
    Index row = input_.first_row;
    for (const ControlNode& node : control_.points()) {
      check.points.push_back(CheckPoint(node, row));
      row += node.directions.cols();
    }
    check.shift = FindShift();
    check.ComputeAccuracy();
    return check;
  }

 private:
  ControlPointCheck CheckPoint(const ControlNode& node, Index row) const {
    const ControlPoint& point = control_.Point(node);
    const Index size = node.directions.cols();
    ControlPointCheck check;
    check.name = point.name;
    check.where = point.where.ToString();
    check.role = Role(node);
    check.directions_enu = network_.flight().frame.R_m_enu(point.p_m).transpose() * node.directions;
    const MatrixXd W = SurveyWhitening(network_, node), W_inverse = W.inverse();
    check.survey_sigma_m = W_inverse.rowwise().norm();
    const BlockRecord& block = network_.net().block(node.deviation);
    const VectorXd r = W * (VectorXd::Map(block.value.get(), size) + change_.segment(row, size));
    const MatrixXd H =
        W * (input_.marginals.DiagonalBlock(node.deviation) + added_.block(row, row, size, size)) *
        W.transpose();
    const MatrixXd one = MatrixXd::Identity(size, size);
    // The prediction from all other data (PredictFactor): its residual and its covariance.
    const bool active = network_.net().factor(node.survey).active;
    const MatrixXd covariance = active ? MatrixXd((one - H).inverse()) : MatrixXd(one + H);
    const VectorXd residual = active ? VectorXd(covariance * r) : r;
    check.residual_m = W_inverse * residual;
    check.covariance_m2 = W_inverse * covariance * W_inverse.transpose();
    check.statistic = residual.dot(covariance.llt().solve(residual));
    check.dof = static_cast<int>(size);
    check.p_value = std::min(1.0, static_cast<double>(control_.points().size()) *
                                      ChiSquareTail(check.statistic, check.dof));
    if (active && input_.of_boresight) {
      const MatrixXd cross =
          input_.marginals.Covariance(network_.calibration().boresight().id, node.deviation) +
          added_.block(0, row, 3, size);
      check.boresight_rad = cross * W.transpose() * residual;
    }
    return InEastNorthUp(std::move(check));
  }

  /// Turns the components of a point from map axes to local east, north, up.
  static ControlPointCheck InEastNorthUp(ControlPointCheck check) {
    if (check.directions_enu.cols() != 3) return check;
    const Eigen::Matrix3d R = check.directions_enu;
    check.residual_m = R * check.residual_m;
    check.covariance_m2 = R * check.covariance_m2 * R.transpose();
    check.survey_sigma_m = (R.cwiseAbs2() * check.survey_sigma_m.cwiseAbs2()).cwiseSqrt();
    check.directions_enu = Eigen::Matrix3d::Identity();
    return check;
  }

  ControlPointCheck::Role Role(const ControlNode& node) const {
    const std::vector<std::size_t>& rejected = input_.adjustment.control_rejected;
    if (std::find(rejected.begin(), rejected.end(), node.point) != rejected.end()) {
      return ControlPointCheck::Role::kRejected;
    }
    return control_.Point(node).is_check ? ControlPointCheck::Role::kCheck
                                         : ControlPointCheck::Role::kObservation;
  }

  std::optional<ControlShift> FindShift() const {
    ControlShift shift;
    if (const auto block = control_.datum_shift()) {
      const Eigen::Matrix3d R_enu_m =
          network_.flight()
              .frame.R_m_enu(control_.Point(control_.points().front()).p_m)
              .transpose();
      const Index row = change_.size() - 3;
      const Eigen::Matrix3d covariance =
          input_.marginals.Covariance(*block) + added_.block<3, 3>(row, row);
      shift.shift_m = R_enu_m * (network_.net().Value(*block) + change_.tail<3>());
      shift.sigma_m = (R_enu_m * covariance * R_enu_m.transpose()).diagonal().cwiseSqrt();
      shift.estimated = true;
      return shift;
    }
    if (!input_.shift_block) return std::nullopt;
    const JointScore score = input_.unmodelled.Conditioned();
    const ScoreTest test = TestJointly(score, score.Components(*input_.shift_block));
    if (test.dof < 1) return std::nullopt;
    shift.shift_m = test.estimate;
    shift.sigma_m = test.covariance.diagonal().cwiseSqrt();
    shift.statistic = test.statistic;
    shift.p_value = ChiSquareTail(test.statistic, test.dof);
    return shift;
  }

  const ControlCheckInput& input_;
  const FlightNetwork& network_;
  const ControlEdges& control_;
  VectorXd change_;
  MatrixXd added_;
};

}  // namespace

std::vector<BlockId> ControlDeviations(const FlightNetwork& network) {
  std::vector<BlockId> deviations;
  for (const ControlNode& node : network.control().points()) deviations.push_back(node.deviation);
  if (const auto shift = network.control().datum_shift()) deviations.push_back(shift->id);
  return deviations;
}

EffectModel ControlShiftColumns(const FlightNetwork& network) {
  const ControlEdges& control = network.control();
  EffectModel columns;
  if (control.datum_shift()) return columns;
  for (const ControlNode& node : control.points()) {
    if (!network.net().factor(node.survey).active) continue;
    const Eigen::Matrix3d R_m_enu = network.flight().frame.R_m_enu(control.Point(node).p_m);
    columns.push_back(
        {node.survey, SurveyWhitening(network, node) * node.directions.transpose() * R_m_enu});
  }
  return columns;
}

std::optional<ControlCheck> CheckControl(const ControlCheckInput& input) {
  if (input.adjustment.network->control().points().empty()) return std::nullopt;
  return Checker(input).Run();
}

}  // namespace dn::diagnosis_internal
