#include "plane_effects.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cstddef>
#include <utility>
#include <vector>

#include "end_derivatives.h"
#include "lidar_effects.h"
#include "unmodelled.h"

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// Normal equations of the boresight and the other unknowns of the problem, with the effects of the
/// scanner on their right-hand side. Planes are eliminated one by one.
class PlaneShifts {
 public:
  PlaneShifts(const Flight& flight, const PlaneCalibration& calibration,
              const std::vector<Hypothesis>& hypotheses)
      : calibration_(calibration),
        hypotheses_(hypotheses),
        derivatives_(flight, calibration.problem.lever_arm_b_m,
                     calibration.adjustment.boresight_rad),
        unknowns_(calibration.adjustment.covariance_apriori.rows()) {
    for (const Hypothesis& hypothesis : hypotheses) components_ += hypothesis.typical.size();
  }

  /// Returns the shift of the boresight per unit of each component.
  MatrixXd Run() const {
    MatrixXd right = MatrixXd::Zero(unknowns_, components_);
    for (std::size_t q = 0; q < calibration_.problem.planes.size(); ++q) Add(q, &right);
    return -(calibration_.adjustment.covariance_apriori * right).topRows<3>();
  }

 private:
  void Add(std::size_t q, MatrixXd* right) const {
    const ObservedPlane& plane = calibration_.problem.planes[q];
    Eigen::Matrix3d Q = Eigen::Matrix3d::Zero();
    MatrixXd X = MatrixXd::Zero(unknowns_, 3), Y = MatrixXd::Zero(3, components_);
    bool any = false;
    for (std::size_t k = 0; k < plane.points.size(); ++k) {
      if (calibration_.adjustment.kept[q][k] == 0) continue;
      any = true;
      const PlaneState& state = calibration_.adjustment.planes[q];
      const PlanePointLinearisation at = LinearisePlanePoint(
          plane.points[k], plane.sigma_m, calibration_.problem.lever_arm_b_m,
          calibration_.adjustment.boresight_rad, calibration_.adjustment.range_offset_m, state);
      const double weight = 1.0 / at.variance_m2;
      const PlaneUnknownRow unknowns(calibration_.problem, plane.points[k], at);
      const Eigen::RowVectorXd row = state.normal.transpose() * PointColumns(plane.points[k].end);
      for (std::size_t i = 0; i < unknowns.size; ++i) {
        right->row(unknowns.at[i]) += weight * unknowns.value[i] * row;
        X.row(unknowns.at[i]) += weight * unknowns.value[i] * at.J_plane.transpose();
      }
      Q += weight * at.J_plane * at.J_plane.transpose();
      Y += weight * at.J_plane * row;
    }
    if (any) *right -= X * Eigen::Matrix3d(Q.inverse()) * Y;
  }

  /// Returns d point / d effects, 3 x components.
  MatrixXd PointColumns(const GaussHelmertEnd& end) const {
    const PairEnd at = derivatives_.At(end, Vector3d::Zero(), Eigen::Matrix3d::Identity());
    MatrixXd columns(3, components_);
    Index first = 0;
    for (const Hypothesis& hypothesis : hypotheses_) {
      const Index size = hypothesis.typical.size();
      columns.middleCols(first, size) = EndColumns(hypothesis, at);
      first += size;
    }
    return columns;
  }

  const PlaneCalibration& calibration_;
  const std::vector<Hypothesis>& hypotheses_;
  EndDerivatives derivatives_;
  Index unknowns_;
  Index components_ = 0;
};

/// Returns the effects of the scanner that the adjustment does not estimate.
std::vector<Hypothesis> NotEstimated(const Flight& flight, const PlaneCalibration& calibration) {
  std::vector<Hypothesis> left;
  for (Hypothesis& hypothesis : ScannerHypotheses(flight)) {
    if (calibration.problem.with_range_offset && hypothesis.id == EffectId::kLidarRangeOffset) {
      continue;
    }
    left.push_back(std::move(hypothesis));
  }
  return left;
}

}  // namespace

std::optional<UnmodelledEffects> PlaneEffects(const Flight& flight,
                                              const PlaneCalibration& calibration) {
  const std::vector<Hypothesis> hypotheses = NotEstimated(flight, calibration);
  Library library;
  JointScore score;  // without information: the adjustment does not show the effects
  score.first = {0};
  for (const Hypothesis& hypothesis : hypotheses) {
    library.Add(hypothesis, {});
    score.first.push_back(score.first.back() + hypothesis.typical.size());
  }
  const Index n = score.first.back();
  score.s = score.signature2 = Eigen::VectorXd::Zero(n);
  score.A = MatrixXd::Zero(n, n);
  score.shift = PlaneShifts(flight, calibration, hypotheses).Run();
  const UnmodelledUnknowns unmodelled(library, MakeUnmodelledPrior(flight.config), score);
  if (unmodelled.empty()) return std::nullopt;
  UnmodelledEffects effects;
  effects.covariance_rad2 = unmodelled.PriorCovariance();
  effects.contributions = unmodelled.Contributions({0}, false);
  return effects;
}

}  // namespace dn::diagnosis_internal
