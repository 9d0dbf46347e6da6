#include "gauss_helmert_effects.h"

#include <dn/calibration/pose_interpolator.h>
#include <dn/rotation.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <compare>
#include <map>
#include <utility>

#include "effect_screen.h"
#include "lasting_errors.h"
#include "lidar_effects.h"
#include "model_findings.h"

namespace dn::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Half the step of the numerical derivatives by time.
constexpr double kHalfStep_s = 5e-3;
// More pairs say the same.
constexpr std::size_t kMostPairs = 20000;
// Of the errors of the trajectory, in octaves: about one above what is stated, five at most.
constexpr int kMostOctaves = 5;
constexpr double kOctavesSigma = 1.0;
// Of the white noise, from what is stated to sigma0 times that.
constexpr int kWhiteSteps = 2;

/// Velocity of points that are fixed to the body, along a trajectory.
class PointVelocity {
 public:
  explicit PointVelocity(const Flight& flight)
      : first_s_(flight.trajectory->points().front().t_s),
        last_s_(flight.trajectory->points().back().t_s),
        poses_(flight.trajectory->InMap(flight.frame)) {}

  Vector3d At(double t_s, const Vector3d& s_b) const {
    const double t0_s = std::max(first_s_, t_s - kHalfStep_s);
    const double t1_s = std::min(last_s_, t_s + kHalfStep_s);
    const MapPose a = poses_.At(t0_s), b = poses_.At(t1_s);
    return (b.p_mb + b.q_mb * s_b - a.p_mb - a.q_mb * s_b) / (t1_s - t0_s);
  }

 private:
  double first_s_, last_s_;
  PoseInterpolator poses_;
};

/// P^-1 of an end: position in map, attitude in body.
Eigen::Matrix<double, 6, 6> NoiseOf(const GaussHelmertEnd& end) {
  const Matrix3d L = end.q_mn.toRotationMatrix() * end.sigma_ned_m.asDiagonal();
  const Vector3d down_b = end.q_mb.conjugate() * (end.q_mn * Vector3d::UnitZ());
  const Matrix3d F = BodyFromEulerRates(down_b) * end.sigma_rph_rad.asDiagonal();
  Eigen::Matrix<double, 6, 6> noise = Eigen::Matrix<double, 6, 6>::Zero();
  noise.topLeftCorner<3, 3>() = L * L.transpose();
  noise.bottomRightCorner<3, 3>() = F * F.transpose();
  return noise;
}

/// The stated covariance of an error of the trajectory, as a square root.
Eigen::Matrix<double, 6, 6> ErrorSqrt(const GaussHelmertCalibration& calibration) {
  const TrajectoryAccuracy& accuracy = calibration.accuracy;
  const Eigen::Quaterniond& q_mn = calibration.problem.pairs.front().i.q_mn;
  Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Zero();
  root.topLeftCorner<3, 3>() = q_mn.toRotationMatrix() * accuracy.sigma_ned_m.asDiagonal();
  root.bottomRightCorner<3, 3>() = accuracy.attitude_covariance_rad2.llt().matrixL();
  return root;
}

/// The pairs kept, linear and whitened, with the ends that effects are made of.
class KeptPairs {
 public:
  std::vector<PairRows> rows;
  std::vector<PairEnds> ends;

  KeptPairs(const Flight& flight, const GaussHelmertCalibration& calibration)
      : lidar_(*flight.config.lidar), calibration_(calibration), velocity_(flight) {
    q_boresight_ = Exp(calibration.adjustment.boresight_rad);
    const auto kept = static_cast<std::size_t>(calibration.adjustment.pairs_kept);
    const std::size_t every = 1 + kept / kMostPairs;
    std::size_t seen = 0;
    for (std::size_t k = 0; k < calibration.problem.pairs.size(); ++k) {
      if (calibration.adjustment.weights[k] > 0.0 && seen++ % every == 0) Add(k);
    }
  }

 private:
  void Add(std::size_t k) {
    const GaussHelmertPair& pair = calibration_.problem.pairs[k];
    const PairCorrection& v = calibration_.adjustment.corrections[k];
    const PairLinearisation at =
        LinearisePair(pair, calibration_.problem.lever_arm_b_m, calibration_.options.model,
                      calibration_.adjustment.boresight_rad, v);
    Matrix3d covariance = pair.covariance_m2;
    covariance += at.B.leftCols<6>() * NoiseOf(pair.i) * at.B.leftCols<6>().transpose();
    covariance += at.B.rightCols<6>() * NoiseOf(pair.j) * at.B.rightCols<6>().transpose();
    const Matrix3d root = covariance.llt().matrixL();
    const Matrix3d W = std::sqrt(calibration_.adjustment.weights[k]) * Matrix3d(root.inverse());
    rows.push_back({pair.i.t_s, pair.j.t_s, W * (at.w - at.B * v), W * at.A, W * at.B.leftCols<6>(),
                    W * at.B.rightCols<6>()});
    ends.push_back({static_cast<FactorId>(ends.size()), EndOf(pair.i, v.segment<3>(3), W),
                    EndOf(pair.j, v.segment<3>(9), -W)});
  }

  PairEnd EndOf(const GaussHelmertEnd& end, const Vector3d& v_phi, const Matrix3d& W) const {
    const Matrix3d& R_bs = lidar_.mounting.R_bs_nominal;
    const Vector3d s_b = calibration_.problem.lever_arm_b_m + q_boresight_ * end.u_b;
    PairEnd out;
    out.t_s = end.t_s;
    out.u_s = R_bs.transpose() * end.u_b;
    out.J_r_a = W * (end.q_mb * Exp(v_phi)).toRotationMatrix();
    out.J_r_u = out.J_r_a * q_boresight_.toRotationMatrix() * R_bs;
    out.J_r_t = -W * velocity_.At(end.t_s, s_b);
    return out;
  }

  const LidarConfig& lidar_;
  const GaussHelmertCalibration& calibration_;
  PointVelocity velocity_;
  Eigen::Quaterniond q_boresight_;
};

BoresightPrior PriorOfBoresight(const GaussHelmertCalibration& calibration) {
  BoresightPrior prior;
  if (const auto& sigma_rad = calibration.problem.boresight_sigma_rad) {
    prior.weight = sigma_rad->cwiseAbs2().cwiseInverse().asDiagonal();
    prior.gradient = prior.weight * AwayFromStated(calibration);
  }
  return prior;
}

/// The scales looked at, by their steps from the stated ones.
struct ScaleSteps {
  int position = 0, attitude = 0, white = 0;
  auto operator<=>(const ScaleSteps&) const = default;
};

/// What speaks for a scale.
struct ScaleEvidence {
  double of_errors = 0.0;  ///< nats, without any effect
  double of_both = 0.0;    ///< with the likeliest effect, or without where that is likelier
  JointScore score;
};

/// Finds the likeliest scale of the errors. Errors alone have one; errors with an effect may have
/// another, near what is stated.
class ScaleSearch {
 public:
  ScaleSearch(const LastingErrors& errors, const std::vector<CandidateEffect>& candidates,
              double sigma0)
      : errors_(errors), candidates_(candidates), sigma0_(std::max(1.0, sigma0)) {}

  ErrorScale Likeliest() {
    const ScaleSteps noisy{0, 0, Most(&ScaleSteps::white)};
    const ScaleSteps alone = Climb(noisy, &ScaleEvidence::of_errors);
    for (const ScaleSteps start : {ScaleSteps{}, noisy, alone}) {
      const ScaleSteps top = Climb(start, &ScaleEvidence::of_both);
      if (At(top).of_both > At(likeliest_).of_both) likeliest_ = top;
    }
    return ScaleOf(likeliest_);
  }

  /// Of the effects beside errors of the likeliest scale.
  const JointScore& score() { return At(likeliest_).score; }

 private:
  ErrorScale ScaleOf(const ScaleSteps& steps) const {
    return {std::exp2(steps.position), std::exp2(steps.attitude),
            std::pow(sigma0_, static_cast<double>(steps.white) / kWhiteSteps)};
  }

  const ScaleEvidence& At(const ScaleSteps& steps) {
    const auto known = known_.find(steps);
    if (known != known_.end()) return known->second;
    LastingErrors::AtScale at = errors_.At(ScaleOf(steps));
    ScaleEvidence evidence;
    const double octaves2 =
        steps.position * steps.position + static_cast<double>(steps.attitude * steps.attitude);
    evidence.of_errors = at.log_likelihood - 0.5 * octaves2 / (kOctavesSigma * kOctavesSigma);
    double of_effect = 0.0;
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      const double nats = LogEvidence(at.score, at.score.Components(k), candidates_[k].typical);
      of_effect = std::max(of_effect,
                           nats - std::log(static_cast<double>(candidates_.size()) / kFamilyLevel));
    }
    evidence.of_both = evidence.of_errors + of_effect;
    evidence.score = std::move(at.score);
    return known_.emplace(steps, std::move(evidence)).first->second;
  }

  /// From a start to a scale that no neighbour exceeds.
  ScaleSteps Climb(ScaleSteps top, double ScaleEvidence::*height) {
    for (bool higher = true; higher;) {
      higher = false;
      for (int ScaleSteps::*which :
           {&ScaleSteps::position, &ScaleSteps::attitude, &ScaleSteps::white}) {
        for (const int step : {-1, 1}) {
          ScaleSteps next = top;
          next.*which += step;
          if (next.*which < 0 || next.*which > Most(which)) continue;
          if (At(next).*height <= At(top).*height) continue;
          top = next;
          higher = true;
        }
      }
    }
    return top;
  }

  int Most(int ScaleSteps::*which) const {
    if (which != &ScaleSteps::white) return kMostOctaves;
    return sigma0_ > 1.0 ? kWhiteSteps : 0;
  }

  const LastingErrors& errors_;
  const std::vector<CandidateEffect>& candidates_;
  double sigma0_;
  ScaleSteps likeliest_;
  std::map<ScaleSteps, ScaleEvidence> known_;
};

/// Of the boresight without the effects, where the reliable ones hold them, too.
Vector3d SigmaBesideEffects(const LastingErrors& errors, const ErrorScale& scale,
                            const GaussHelmertCalibration& calibration) {
  const Matrix3d covariance = errors.OfBoresight(scale) + calibration.constant_rad2;
  return covariance.diagonal().cwiseSqrt().cwiseMin(calibration.boresight.sigma_rad());
}

Eigen::VectorXd OfAllComponents(const EffectScreen& screen, const JointScore& score) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(score.s.size());
  Eigen::Index at = 0;
  for (const std::size_t k : screen.chosen) {
    for (const Eigen::Index c : score.Components(k)) all[c] = screen.joint[at++];
  }
  return all;
}

}  // namespace

Vector3d AwayFromStated(const GaussHelmertCalibration& calibration) {
  return Log(Eigen::Quaterniond(Exp(calibration.boresight.angles_rad) *
                                Exp(calibration.problem.boresight_rad).conjugate()));
}

GaussHelmertEffects FindEffects(const Flight& flight, const std::vector<StripInterval>& strips,
                                const GaussHelmertCalibration& calibration) {
  const KeptPairs pairs(flight, calibration);
  const std::vector<CandidateEffect> candidates = EffectsOfScanner(flight, pairs.ends);
  const LastingErrors errors(pairs.rows, strips, ErrorSqrt(calibration),
                             PriorOfBoresight(calibration), candidates);
  GaussHelmertEffects out;
  ScaleSearch search(errors, candidates, calibration.figures.sigma0);
  const ErrorScale scale = search.Likeliest();
  const EffectScreen screen = ScreenEffects(candidates, search.score(),
                                            {static_cast<double>(candidates.size()),
                                             SigmaBesideEffects(errors, scale, calibration), true});
  out.effects = screen.effects;
  if (!screen.chosen.empty()) {
    out.share_left = errors.ShareLeft(OfAllComponents(screen, search.score()));
  }
  return out;
}

}  // namespace dn::internal
