#include "gauss_helmert_assessment.h"

#include <dn/report/distributions.h>
#include <dn/rotation.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <numbers>

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

[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof(text), format, arguments);
  va_end(arguments);
  return text;
}

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
double AttitudeInPairs(const GaussHelmertProblem& problem, const Vector3d& sigma_rph_rad) {
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

std::string Triple(const Vector3d& rad) {
  return Format("%.5f, %.5f, %.5f deg", rad.x() * kDegPerRad, rad.y() * kDegPerRad,
                rad.z() * kDegPerRad);
}

std::string WhyTheSigmasDiffer(const GaussHelmertCalibration& calibration) {
  const BoresightResult& boresight = calibration.boresight;
  const TrajectoryScatter& scatter = calibration.scatter;
  const Vector3d ratio = boresight.sigma_rad().cwiseQuotient(*boresight.sigma_scaled_rad);
  if (ratio.maxCoeff() < kMuchWider) return {};
  std::string text = Format(
      "the reliable sigmas are %.1f, %.1f and %.1f times those of the normal matrix "
      "(sigma_scaled_deg: %s), which take the errors of the trajectory as new at every epoch",
      ratio.x(), ratio.y(), ratio.z(), Triple(*boresight.sigma_scaled_rad).c_str());
  const std::string scattered = Triple(scatter.covariance_rad2.diagonal().cwiseSqrt());
  if (calibration.accuracy.covariance) {
    return text + "; by " + calibration.accuracy.source + " they last, and scatter the angles by " +
           scattered;
  }
  text += Format(
      "; an attitude error that is constant over the flight, of %s in roll, pitch and yaw by %s, "
      "is absorbed without a trace",
      Triple(calibration.constant_rad2.diagonal().cwiseSqrt()).c_str(),
      calibration.accuracy.source.c_str());
  if (scatter.evidence_nats > kEvidentNats) {
    text += Format(
        ", and the pairs show errors that last for about %.0f s and scatter the angles by %s",
        scatter.tau_s, scattered.c_str());
  }
  return text;
}

std::string AboutStrips(const StripDiversity& diversity) {
  if (diversity.sufficient()) return {};
  return Format(
      "%d strip%s%s: four parallel strips, or three of which one crosses or lies at another "
      "height, determine yaw more reliably",
      diversity.strips, diversity.strips == 1 ? "" : "s",
      diversity.strips == 3 ? ", parallel and at one height" : "");
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
  if (boresight.verdict == "calibrated") AssessLargestSigma(boresight.sigma_rad(), &boresight);
  const auto add = [&](const std::string& reason) {
    if (!reason.empty()) boresight.reasons.push_back(reason);
  };
  const Vector3d attitude_rad =
      calibration->accuracy.sigma_rph_rad * std::max(1.0, calibration->scatter.attitude_ratio);
  const double attitude_m = AttitudeInPairs(calibration->problem, attitude_rad);
  const double pair_m = PairSigma(calibration->problem);
  const std::string sizes = Format(
      "the attitude error of the trajectory (%s) changes the difference of a pair by %.3f m at "
      "%.0f m, whose own sigma is %.3f m",
      Triple(attitude_rad).c_str(), attitude_m, calibration->mean_range_m, pair_m);
  const bool noise_level = attitude_m <= kNoiseLevel * pair_m;
  const Vector3d envelope_rad = kRadPerDeg * Eigen::Map<const Vector3d>(kEnvelopeDeg);
  if (!noise_level && (attitude_rad.array() > envelope_rad.array()).any()) {
    if (boresight.verdict == "calibrated") boresight.verdict = "absorbed";
    add(sizes +
        ": the angles contain that error and make the cloud consistent, but are not those of "
        "the mounting; the dynamic network separates the two");
  } else if (noise_level) {
    add(sizes + ": noise level");
  } else {
    add(sizes + ": tactical grade or better, held by the sigmas given");
  }
  add(AboutStrips(calibration->diversity));
  if (adjustment.pairs_kept < kFewPairs) {
    add(Format("only %ld pairs", adjustment.pairs_kept));
  }
  add(WhyTheSigmasDiffer(*calibration));
  for (const EstimateEntry& entry : flight.config.estimate) {
    if (entry.unknown != "boresight") {
      add(entry.unknown +
          " is not estimated: the Gauss-Helmert adjustment knows the boresight only");
    }
  }
}

}  // namespace internal

MethodDifference Compare(const BoresightResult& a, const BoresightResult& b) {
  MethodDifference out;
  out.difference_rad = Log(Eigen::Quaterniond(Exp(a.angles_rad) * Exp(b.angles_rad).conjugate()));
  out.covariance_rad2 = CovarianceOfDifference(a.covariance_rad2, b.covariance_rad2);
  out.mahalanobis2 = out.difference_rad.dot(out.covariance_rad2.inverse() * out.difference_rad);
  out.p_value = ChiSquareTail(out.mahalanobis2, 3.0);
  return out;
}

void AssessAgainstNetwork(const BoresightResult& network, GaussHelmertCalibration* gauss_helmert) {
  BoresightResult& boresight = gauss_helmert->boresight;
  const MethodDifference difference = Compare(boresight, network);
  const bool contradicts = difference.p_value < kThreeSigma;
  if (contradicts && boresight.verdict == "calibrated") boresight.verdict = "absorbed";
  boresight.reasons.push_back(
      Format("differs from the dynamic network by %s (p = %.2g): %s",
             Triple(difference.difference_rad).c_str(), difference.p_value,
             contradicts
                 ? "more than their covariances explain, so the trajectory holds an attitude error "
                   "beyond its stated sigma, and the network's angles are the mounting's"
                 : "within what their covariances explain"));
}

}  // namespace dn
