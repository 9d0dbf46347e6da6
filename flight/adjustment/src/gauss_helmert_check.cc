#include "gauss_helmert_check.h"

#include <dn/report/distributions.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fixed_trajectory.h"
#include "gauss_helmert_effects.h"
#include "model_findings.h"

namespace dn::internal {
namespace {

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
      lu.solve(calibration.adjustment.normal * DeviationFromPrior(calibration));
  const Eigen::Matrix3d covariance = Eigen::Matrix3d(P.inverse()) + Eigen::Matrix3d(lu.inverse()) +
                                     calibration.boresight.covariance_rad2;
  PriorCheck prior;
  prior.unknown = "boresight";
  prior.dof = 3;
  prior.statistic = predicted_rad.dot(covariance.llt().solve(predicted_rad));
  prior.p_value = ChiSquareTail(prior.statistic, prior.dof);
  return prior;
}

}  // namespace

ModelCheck CheckGaussHelmert(const Flight& flight, const std::vector<StripInterval>& strips,
                             const GaussHelmertCalibration& calibration) {
  const GaussHelmertEffects found = FindEffects(flight, strips, calibration);
  ModelCheck check;
  check.of_boresight = true;
  check.groups.push_back(MakeGroupCheck("lidar p2p", 3 * calibration.figures.correspondences,
                                        calibration.figures, calibration.scatter));
  if (const auto prior = CheckStatedPrior(calibration)) check.priors.push_back(*prior);
  check.effects = found.effects;
  check.departures = found.departures;
  check.groups.front().ratio_with_effects *= found.share_left;
  check.sigma0_with_effects =
      calibration.figures.sigma0 * std::sqrt(found.share_left / calibration.scatter.expected_ratio);
  check.p_value = check.SmallestPValue();
  AddFindings(flight, calibration, &check);
  return check;
}

}  // namespace dn::internal
