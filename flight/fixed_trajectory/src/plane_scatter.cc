#include <dn/error.h>
#include <dn/fixed_trajectory/plane_adjustment.h>

#include <Eigen/LU>
#include <array>
#include <string>
#include <vector>

#include "scatter_of_sums.h"

namespace dn {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using fixed_trajectory_internal::EndJacobian;
using fixed_trajectory_internal::NodeHeadings;
using fixed_trajectory_internal::NodeSums;
using fixed_trajectory_internal::TimeNodes;

/// Derivatives of one condition with respect to the errors at the nodes (6 n + c), followed by the
/// unknowns.
struct SparseRow {
  static constexpr std::size_t kErrors = 12;  // six errors of each of the two nodes around an epoch
  std::array<Index, kErrors + PlaneUnknownRow::kMost> at{};
  std::array<double, kErrors + PlaneUnknownRow::kMost> value{};
  std::size_t size = 0;

  void Add(Index index, double x) {
    at[size] = index;
    value[size++] = x;
  }
};

/// Local indices of the columns that a plane uses, in the order of their first use.
class LocalColumns {
 public:
  explicit LocalColumns(Index all) : local_(static_cast<std::size_t>(all), -1) {}

  Index operator()(Index column) {
    Index& local = local_[static_cast<std::size_t>(column)];
    if (local < 0) {
      local = static_cast<Index>(columns_.size());
      columns_.push_back(column);
    }
    return local;
  }
  const std::vector<Index>& columns() const { return columns_; }
  void Clear() {
    for (const Index column : columns_) local_[static_cast<std::size_t>(column)] = -1;
    columns_.clear();
  }

 private:
  std::vector<Index> local_;
  std::vector<Index> columns_;
};

class PlaneSums {
 public:
  PlaneSums(const PlaneProblem& problem, const PlaneAdjustment& result,
            const TrajectoryErrorOptions& options, const TimeNodes& nodes)
      : problem_(problem),
        result_(result),
        options_(options),
        nodes_(nodes),
        errors_(6 * nodes.size()),
        unknowns_(problem.NumUnknowns()),
        laser_change_(result.laser - problem.laser.start),
        headings_(nodes),
        local_(errors_ + unknowns_) {
    M_.setZero(errors_ + unknowns_, errors_ + unknowns_);
    r_.setZero(errors_ + unknowns_);
  }

  NodeSums Run() {
    for (std::size_t q = 0; q < problem_.planes.size(); ++q) Add(q);
    NodeSums sums(nodes_.size(), unknowns_);
    sums.H = M_.topLeftCorner(errors_, errors_);
    sums.N_e = M_.topRightCorner(errors_, unknowns_);
    sums.b = r_.head(errors_);
    sums.N = M_.bottomRightCorner(unknowns_, unknowns_);
    sums.g = r_.tail(unknowns_);
    sums.chi2 = chi2_;
    sums.heading_rad = headings_.heading_rad();
    AddPriors(&sums);
    sums.OrderByComponent();
    return sums;
  }

 private:
  SparseRow ConditionRow(const PlanePoint& point, const Vector3d& normal,
                         const PlanePointLinearisation& at) const {
    // n^T d x / d phi = J_phi^T, so only this row of the point's Jacobian is needed.
    const Eigen::Matrix3d J_phi = normal * at.J_phi.transpose();
    const Eigen::Matrix<double, 1, 6> errors =
        normal.transpose() * fixed_trajectory_internal::ErrorJacobian(point.end, J_phi, options_);
    const TimeNodes::Place place = nodes_.At(point.end.t_s);
    SparseRow row;
    const auto add = [&](int node, double weight) {
      for (Index c = 0; c < 6; ++c) row.Add(6 * node + c, weight * errors[c]);
    };
    add(place.node, 1.0 - place.next);
    if (place.next_node != place.node) add(place.next_node, place.next);
    const PlaneUnknownRow unknowns(problem_, point, at);
    for (std::size_t i = 0; i < unknowns.size; ++i) {
      row.Add(errors_ + unknowns.at[i], unknowns.value[i]);
    }
    return row;
  }

  void Add(std::size_t q) {
    const ObservedPlane& plane = problem_.planes[q];
    const PlaneState& state = result_.planes[q];
    Eigen::Matrix3d Q = Eigen::Matrix3d::Zero();
    Vector3d y = Vector3d::Zero();
    std::vector<Vector3d> X;  // one vector per local column of the plane
    local_.Clear();
    for (std::size_t k = 0; k < plane.points.size(); ++k) {
      if (result_.kept[q][k] == 0) continue;
      const PlanePoint& point = plane.points[k];
      const PlanePointLinearisation at =
          LinearisePlanePoint(point, plane.sigma_m, problem_.lever_arm_b_m, result_.boresight_rad,
                              result_.range_offset_m, state, laser_change_);
      const double weight = 1.0 / at.variance_m2;
      const SparseRow row = ConditionRow(point, state.normal, at);
      headings_.Add(point.end);
      for (std::size_t i = 0; i < row.size; ++i) {
        for (std::size_t j = 0; j < row.size; ++j) {
          M_(row.at[i], row.at[j]) += weight * row.value[i] * row.value[j];
        }
        r_[row.at[i]] += weight * at.f_m * row.value[i];
        const auto column = static_cast<std::size_t>(local_(row.at[i]));
        if (column == X.size()) X.push_back(Vector3d::Zero());
        X[column] += weight * row.value[i] * at.J_plane;
      }
      Q += weight * at.J_plane * at.J_plane.transpose();
      y += weight * at.f_m * at.J_plane;
      chi2_ += weight * at.f_m * at.f_m;
    }
    if (!X.empty()) Eliminate(Q, y, X);
  }

  void Eliminate(const Eigen::Matrix3d& Q, const Vector3d& y, const std::vector<Vector3d>& X) {
    const Eigen::Matrix3d Q_inverse = Q.inverse();
    const std::vector<Index>& columns = local_.columns();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const Vector3d gain = Q_inverse * X[i];
      for (std::size_t j = 0; j < columns.size(); ++j) M_(columns[i], columns[j]) -= gain.dot(X[j]);
      r_[columns[i]] -= gain.dot(y);
    }
  }

  void AddPriors(NodeSums* sums) const {
    if (problem_.boresight_sigma_rad) {
      sums->N.topLeftCorner<3, 3>() +=
          problem_.boresight_sigma_rad->cwiseAbs2().cwiseInverse().asDiagonal();
    }
    if (problem_.with_range_offset && problem_.range_offset_sigma_m) {
      sums->N(3, 3) += 1.0 / (*problem_.range_offset_sigma_m * *problem_.range_offset_sigma_m);
    }
    const Index laser = problem_.laser.size();
    sums->N.bottomRightCorner(laser, laser) += problem_.laser.information;
  }

  const PlaneProblem& problem_;
  const PlaneAdjustment& result_;
  const TrajectoryErrorOptions& options_;
  const TimeNodes& nodes_;
  const Index errors_, unknowns_;
  const VectorXd laser_change_;
  NodeHeadings headings_;
  LocalColumns local_;
  MatrixXd M_;  // errors first, then unknowns
  VectorXd r_;
  double chi2_ = 0.0;
};

std::vector<double> KeptEpochs(const PlaneProblem& problem, const PlaneAdjustment& result) {
  std::vector<double> t_s;
  for (std::size_t q = 0; q < problem.planes.size(); ++q) {
    for (std::size_t k = 0; k < problem.planes[q].points.size(); ++k) {
      if (result.kept[q][k] != 0) t_s.push_back(problem.planes[q].points[k].end.t_s);
    }
  }
  return t_s;
}

}  // namespace

PlaneErrorCovariance EstimateCorrelatedErrorCovariance(const PlaneProblem& problem,
                                                       const PlaneAdjustment& result,
                                                       const TrajectoryErrorOptions& options) {
  options.Validate();
  if (result.kept.size() != problem.planes.size()) {
    throw InvalidInput("the adjustment has " + std::to_string(result.kept.size()) +
                       " planes, the problem " + std::to_string(problem.planes.size()));
  }
  if (!(result.chi2 > 0.0)) {  // all residuals are zero
    PlaneErrorCovariance none;
    none.trajectory.other_variances = VectorXd::Zero(problem.NumUnknowns() - 3);
    return none;
  }
  const fixed_trajectory_internal::AdjustmentErrorCovariance out =
      fixed_trajectory_internal::EstimateFromNodeSums(
          static_cast<double>(result.redundancy), options,
          [&] { return KeptEpochs(problem, result); },
          [&](const TimeNodes& nodes) { return PlaneSums(problem, result, options, nodes).Run(); });
  return {out.scatter, problem.with_range_offset ? out.covariance(3, 3) : 0.0};
}

}  // namespace dn
