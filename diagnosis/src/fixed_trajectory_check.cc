#include <dn/diagnosis/model_check.h>
#include <dn/distributions.h>
#include <dn/stopwatch.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "gauss_helmert_effects.h"
#include "linear_pairs.h"
#include "model_findings.h"
#include "plane_effects.h"

namespace dn {
namespace {

/// Starts the check of an adjustment with its only group. Compares the sum of squares with its
/// expectation under the stated, time-correlated errors of the trajectory.
ModelCheck StartCheck(const char* name, long observations, const AdjustmentFigures& figures,
                      const CorrelatedErrorCovariance& scatter) {
  const auto redundancy = static_cast<double>(figures.redundancy);
  GroupCheck group;
  group.name = name;
  group.observations = observations;
  group.redundancy = redundancy;
  const double chi2 = figures.chi2 / scatter.expected_ratio;
  group.variance_ratio = group.ratio_with_effects = chi2 / std::max(1.0, redundancy);
  const double dof = scatter.expected_dof > 0.0 ? scatter.expected_dof : std::max(1.0, redundancy);
  const double above = ChiSquareTail(dof * group.variance_ratio, dof);
  group.p_value = std::min(1.0, 2.0 * std::min(above, 1.0 - above));
  ModelCheck check;
  check.of_boresight = true;
  check.groups.push_back(std::move(group));
  check.sigma0_with_effects = figures.sigma0 / std::sqrt(scatter.expected_ratio);
  return check;
}

/// Tests the stated prior against the boresight from the pairs alone, with the reliable covariance
/// of the pairs.
std::optional<PriorCheck> CheckStatedPrior(const GaussHelmertCalibration& calibration) {
  const auto& sigma_rad = calibration.problem.boresight_sigma_rad;
  if (!sigma_rad) return std::nullopt;
  const Eigen::Matrix3d P = sigma_rad->cwiseAbs2().cwiseInverse().asDiagonal();
  const Eigen::Matrix3d pair_normal = calibration.adjustment.normal - P;
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(pair_normal);
  if (!lu.isInvertible()) return std::nullopt;
  const Eigen::Vector3d predicted_rad =
      lu.solve(calibration.adjustment.normal * diagnosis_internal::DeviationFromPrior(calibration));
  const Eigen::Matrix3d covariance = Eigen::Matrix3d(P.inverse()) + Eigen::Matrix3d(lu.inverse()) +
                                     calibration.boresight.covariance_rad2;
  PriorCheck prior;
  prior.unknown = "boresight";
  prior.dof = 3;
  prior.statistic = predicted_rad.dot(covariance.llt().solve(predicted_rad));
  prior.p_value = ChiSquareTail(prior.statistic, prior.dof);
  return prior;
}

template <class Calibration>
ModelCheck CheckAndAssess(const Flight& flight, Calibration* calibration) {
  const Stopwatch watch;
  ModelCheck check = CheckModel(flight, *calibration);
  Assess(check, &calibration->boresight);
  calibration->covariance_time_s += watch.seconds();
  return check;
}

}  // namespace

ModelCheck CheckModel(const Flight& flight, const GaussHelmertCalibration& calibration) {
  const diagnosis_internal::GaussHelmertEffects found =
      diagnosis_internal::FindEffects(flight, FindStrips(flight), calibration);
  ModelCheck check = StartCheck("lidar p2p", 3 * calibration.figures.correspondences,
                                calibration.figures, calibration.scatter);
  if (const auto prior = CheckStatedPrior(calibration)) check.priors.push_back(*prior);
  check.unmodelled = found.unmodelled;
  check.effects = found.effects;
  check.discrepancies = found.discrepancies;
  check.groups.front().ratio_with_effects *= found.share_left;
  check.sigma0_with_effects *= std::sqrt(found.share_left);
  check.p_value = check.SmallestPValue();
  diagnosis_internal::AddFindings(flight, calibration, &check);
  return check;
}

ModelCheck CheckModel(const Flight& flight, const PlaneCalibration& calibration) {
  ModelCheck check = StartCheck("lidar planes", calibration.figures.correspondences,
                                calibration.figures, calibration.scatter.trajectory);
  check.unmodelled = diagnosis_internal::PlaneEffects(flight, calibration);
  check.p_value = check.SmallestPValue();
  diagnosis_internal::AddFindings(flight, calibration, &check);
  return check;
}

ModelCheck AssessModel(const Flight& flight, GaussHelmertCalibration* calibration) {
  return CheckAndAssess(flight, calibration);
}

ModelCheck AssessModel(const Flight& flight, PlaneCalibration* calibration) {
  return CheckAndAssess(flight, calibration);
}

}  // namespace dn
