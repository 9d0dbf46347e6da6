#include "gauss_helmert_assessment.h"

#include <dn/report/distributions.h>
#include <dn/rotation.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kCrossingRad = 20.0 * kRadPerDeg;
constexpr double kHeightPerRange = 0.05;
constexpr long kFewPairs = 30;        // "tens, not hundreds or thousands" are required
constexpr double kEvidentNats = 3.0;  // odds of 20 to 1
// An error of half the pairs' sigma makes the misclosures 12 % larger: below it, it is noise.
constexpr double kNoiseLevel = 0.5;
// Twice the attitude accuracy of the paper's tactical-grade flights, the lowest within its
// envelope.
constexpr double kEnvelopeDeg[] = {0.01, 0.01, 0.02};
constexpr double kThreeSigma = 0.0027;
// Where the reliable sigma exceeds the formal one by more than this, it is worth a sentence.
constexpr double kMuchWider = 1.2;

struct StripMotion {
  double course_rad = 0.0;
  double height_m = 0.0;
};

std::vector<StripMotion> Motions(const Flight& flight, const std::vector<StripInterval>& strips) {
  std::vector<StripMotion> motions;
  for (const StripInterval& strip : strips) {
    const double t_s = 0.5 * (strip.t0_s + strip.t1_s);
    if (!flight.trajectory->Covers(t_s)) continue;
    const NavPoint& point = flight.trajectory->PointFrom(t_s);
    motions.push_back({std::atan2(point.v_ned_mps.y(), point.v_ned_mps.x()), point.position.h_m});
  }
  return motions;
}

double MeanRange(const GaussHelmertProblem& problem) {
  double sum_m = 0.0;
  for (const GaussHelmertPair& pair : problem.pairs) {
    sum_m += pair.i.u_b.norm() + pair.j.u_b.norm();
  }
  return sum_m / (2.0 * static_cast<double>(problem.pairs.size()));
}

/// rms sigma of a pair's difference, per coordinate.
double PairSigma(const GaussHelmertProblem& problem) {
  double sum = 0.0;
  for (const GaussHelmertPair& pair : problem.pairs) sum += pair.covariance_m2.trace() / 3.0;
  return std::sqrt(sum / static_cast<double>(problem.pairs.size()));
}

/// Largest sigma (per coordinate) of the difference of a pair by the attitude errors of its two
/// epochs: roll and pitch act over the range, heading over the distance from the nadir.
double LargestChange(const GaussHelmertProblem& problem, const Vector3d& sigma_rph_rad) {
  double range2 = 0.0, aside2 = 0.0;
  for (const GaussHelmertPair& pair : problem.pairs) {
    for (const GaussHelmertEnd* end : {&pair.i, &pair.j}) {
      const Vector3d down_b = end->q_mb.conjugate() * (end->q_mn * Vector3d::UnitZ());
      range2 += end->u_b.squaredNorm();
      aside2 += end->u_b.cross(down_b).squaredNorm();
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
  const Vector3d envelope_rad = kRadPerDeg * Eigen::Map<const Vector3d>(kEnvelopeDeg);
  using Size = facts::AttitudeInPairs::Size;
  if (fact.change_m <= kNoiseLevel * fact.pair_sigma_m) {
    fact.size = Size::kNoise;
  } else {
    const bool tactical = (fact.sigma_rph_rad.array() <= envelope_rad.array()).all();
    fact.size = tactical ? Size::kHeld : Size::kAbsorbed;
  }
  return fact;
}

facts::SigmasWidened WhyTheSigmasDiffer(const GaussHelmertCalibration& calibration) {
  const BoresightResult& boresight = calibration.boresight;
  const TrajectoryScatter& scatter = calibration.scatter;
  facts::SigmasWidened fact;
  fact.ratio = boresight.sigma_rad().cwiseQuotient(*boresight.sigma_scaled_rad);
  fact.scaled_rad = *boresight.sigma_scaled_rad;
  fact.scattered_rad = scatter.covariance_rad2.diagonal().cwiseSqrt();
  fact.constant_rad = calibration.constant_rad2.diagonal().cwiseSqrt();
  fact.source = calibration.accuracy.source;
  fact.times_stated = calibration.accuracy.covariance.has_value();
  fact.times_shown = scatter.evidence_nats > kEvidentNats;
  fact.tau_s = scatter.tau_s;
  return fact;
}

/// |C_a - C_b|, floored, in the metric of C_a.
Eigen::Matrix3d CovarianceOfDifference(const Eigen::Matrix3d& C_a, const Eigen::Matrix3d& C_b) {
  constexpr double kLeast = 0.1;
  const Eigen::Matrix3d L = C_a.llt().matrixL();
  const Eigen::Matrix3d L_inverse = L.inverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
      Eigen::Matrix3d::Identity() - L_inverse * C_b * L_inverse.transpose());
  const Eigen::Matrix3d G = L * eigen.eigenvectors();
  const Eigen::Vector3d ratio = eigen.eigenvalues().unaryExpr(
      [](double more) { return std::max(std::abs(more), kLeast * std::max(1.0, 1.0 - more)); });
  return G * ratio.asDiagonal() * G.transpose();
}

}  // namespace

namespace internal {

void DescribeStrips(const Flight& flight, const std::vector<StripInterval>& strips,
                    GaussHelmertCalibration* calibration) {
  calibration->mean_range_m = MeanRange(calibration->problem);
  const std::vector<StripMotion> motions = Motions(flight, strips);
  StripDiversity& diversity = calibration->diversity;
  diversity.strips = static_cast<int>(strips.size());
  for (const StripMotion& a : motions) {
    for (const StripMotion& b : motions) {
      const double turn = std::remainder(a.course_rad - b.course_rad, std::numbers::pi);
      if (std::abs(turn) >= kCrossingRad) diversity.crossing = true;
      if (a.height_m - b.height_m >= kHeightPerRange * calibration->mean_range_m) {
        diversity.heights = true;
      }
    }
  }
}

void Assess(const Flight& flight, GaussHelmertCalibration* calibration) {
  BoresightResult& boresight = calibration->boresight;
  const GaussHelmertResult& adjustment = calibration->adjustment;
  AssessObservability(flight, *boresight.sigma_apriori_rad, Vector3d::Zero(), &boresight);
  if (boresight.verdict == Verdict::kCalibrated)
    AssessLargestSigma(boresight.sigma_rad(), &boresight);
  const auto add = [&](Fact fact) { boresight.reasons.push_back({std::move(fact)}); };
  const facts::AttitudeInPairs attitude = AttitudeErrors(*calibration);
  if (attitude.size == facts::AttitudeInPairs::Size::kAbsorbed &&
      boresight.verdict == Verdict::kCalibrated) {
    boresight.verdict = Verdict::kAbsorbed;
  }
  add(attitude);
  const StripDiversity& diversity = calibration->diversity;
  if (!diversity.sufficient()) add(facts::StripsAlike{diversity.strips});
  if (adjustment.pairs_kept < kFewPairs) add(facts::FewPairs{adjustment.pairs_kept});
  const facts::SigmasWidened widened = WhyTheSigmasDiffer(*calibration);
  if (widened.ratio.maxCoeff() >= kMuchWider) add(widened);
  for (const EstimateEntry& entry : flight.config.estimate) {
    if (entry.unknown != "boresight") add(facts::NotEstimated{entry.unknown});
  }
}

}  // namespace internal

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
  return DifferenceWith(CovarianceOfDifference(a.covariance_rad2, b.covariance_rad2), a, b);
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
