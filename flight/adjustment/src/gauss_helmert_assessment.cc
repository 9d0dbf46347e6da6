#include "gauss_helmert_assessment.h"

#include <dn/distributions.h>
#include <dn/rotation.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "fixed_trajectory.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr long kFewPairs = 30;  // "tens, not hundreds or thousands" are required
constexpr double kThreeSigma = 0.0027;

/// Returns the rms sigma of a pair's difference, per coordinate.
double PairSigma(const GaussHelmertProblem& problem) {
  double sum = 0.0;
  for (const GaussHelmertPair& pair : problem.pairs) sum += pair.covariance_m2.trace() / 3.0;
  return std::sqrt(sum / static_cast<double>(problem.pairs.size()));
}

/// Returns the largest sigma, per coordinate, of a pair's difference due to the attitude errors at
/// its two epochs. Roll and pitch act over the range, heading over the distance from the nadir.
double LargestChange(const GaussHelmertProblem& problem, const Vector3d& sigma_rph_rad) {
  double range2 = 0.0, aside2 = 0.0;
  for (const GaussHelmertPair& pair : problem.pairs) {
    for (const GaussHelmertEnd* end : {&pair.i, &pair.j}) {
      range2 += end->u_b.squaredNorm();
      aside2 += end->u_b.cross(end->down_b()).squaredNorm();
    }
  }
  const double n = 2.0 * static_cast<double>(problem.pairs.size());
  return std::numbers::sqrt2 * std::max(sigma_rph_rad.head<2>().maxCoeff() * std::sqrt(range2 / n),
                                        sigma_rph_rad.z() * std::sqrt(aside2 / n));
}

facts::AttitudeInPairs AttitudeErrors(const GaussHelmertCalibration& calibration) {
  facts::AttitudeInPairs fact;
  fact.sigma_rph_rad =
      calibration.accuracy.sigma_rph_rad * std::max(1.0, calibration.scatter.attitude_ratio);
  fact.change_m = LargestChange(calibration.problem, fact.sigma_rph_rad);
  fact.range_m = calibration.mean_range_m;
  fact.pair_sigma_m = PairSigma(calibration.problem);
  fact.size = adjustment_internal::ClassifyAttitudeError(fact.change_m, fact.pair_sigma_m,
                                                         fact.sigma_rph_rad);
  return fact;
}

/// Returns |C_a - C_b| in the metric of C_a, with a lower bound.
Eigen::Matrix3d DifferenceCovariance(const Eigen::Matrix3d& C_a, const Eigen::Matrix3d& C_b) {
  constexpr double kMinShare = 0.1;
  const Eigen::Matrix3d L = C_a.llt().matrixL();
  const Eigen::Matrix3d L_inverse = L.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
      Eigen::Matrix3d::Identity() - L_inverse * C_b * L_inverse.transpose());
  const Eigen::Matrix3d G = L * eigen.eigenvectors();
  const Eigen::Vector3d ratio = eigen.eigenvalues().unaryExpr(
      [](double more) { return std::max(std::abs(more), kMinShare * std::max(1.0, 1.0 - more)); });
  return G * ratio.asDiagonal() * G.transpose();
}

}  // namespace

namespace adjustment_internal {

double MeanRange(const GaussHelmertProblem& problem) {
  double sum_m = 0.0;
  for (const GaussHelmertPair& pair : problem.pairs) {
    sum_m += pair.i.u_b.norm() + pair.j.u_b.norm();
  }
  return sum_m / (2.0 * static_cast<double>(problem.pairs.size()));
}

void Assess(const Flight& flight, GaussHelmertCalibration* calibration) {
  BoresightResult& boresight = calibration->boresight;
  const GaussHelmertResult& adjustment = calibration->adjustment;
  AssessObservability(flight, *boresight.sigma_apriori_rad, Vector3d::Zero(), &boresight);
  if (boresight.verdict == Verdict::kCalibrated)
    AssessLargestSigma(boresight.sigma_rad(), &boresight);
  AddGeometryReasons(AttitudeErrors(*calibration), calibration->diversity, &boresight);
  const bool told = std::any_of(
      boresight.reasons.begin(), boresight.reasons.end(),
      [](const Finding& finding) { return std::holds_alternative<facts::FewPairs>(finding.fact); });
  if (!told && adjustment.pairs_kept < kFewPairs) {
    boresight.reasons.push_back({facts::FewPairs{adjustment.pairs_kept}});
  }
  AddWideningReason(calibration->scatter, calibration->accuracy, calibration->constant_rad2,
                    &boresight);
  AddNotEstimated(flight.config, {"boresight"},
                  "the Gauss-Helmert adjustment estimates the boresight and beams only",
                  &boresight);
  AddBeamsNotEstimated(flight.config, calibration->beams, &boresight);
}

}  // namespace adjustment_internal

namespace {

MethodDifference DifferenceWith(const Eigen::Matrix3d& covariance_rad2, const BoresightResult& a,
                                const BoresightResult& b) {
  MethodDifference out;
  out.difference_rad = Log(Eigen::Quaterniond(Exp(a.angles_rad) * Exp(b.angles_rad).conjugate()));
  out.covariance_rad2 = covariance_rad2;
  out.mahalanobis2 = out.difference_rad.dot(out.covariance_rad2.inverse() * out.difference_rad);
  out.p_value = ChiSquareTail(out.mahalanobis2, 3.0);
  return out;
}

}  // namespace

MethodDifference Compare(const BoresightResult& a, const BoresightResult& b) {
  return DifferenceWith(DifferenceCovariance(a.covariance_rad2, b.covariance_rad2), a, b);
}

MethodDifference CompareIndependent(const BoresightResult& a, const BoresightResult& b) {
  return DifferenceWith(a.covariance_rad2 + b.covariance_rad2, a, b);
}

void AssessAgainstNetwork(const BoresightResult& network, GaussHelmertCalibration* gauss_helmert) {
  BoresightResult& boresight = gauss_helmert->boresight;
  const MethodDifference difference = Compare(boresight, network);
  const bool contradicts = difference.p_value < kThreeSigma;
  if (contradicts && boresight.verdict == Verdict::kCalibrated) {
    boresight.verdict = Verdict::kAbsorbed;
  }
  boresight.reasons.push_back(
      {facts::NetworkDiffers{difference.difference_rad, difference.p_value, contradicts}});
}

}  // namespace dn
