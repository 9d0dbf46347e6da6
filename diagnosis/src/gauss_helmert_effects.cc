#include "gauss_helmert_effects.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <map>
#include <utility>

#include "climb_grid.h"
#include "discrepancies.h"
#include "evidence.h"
#include "lidar_effects.h"
#include "linear_pairs.h"
#include "score_selection.h"
#include "time_correlated_errors.h"
#include "unmodelled.h"

namespace dn::diagnosis_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Steps of the white noise from the stated one to sigma0 times the stated one.
constexpr int kWhiteSteps = 2;
// The scale of the white noise includes the excess.
constexpr double kNoExcess = 1.0;

/// Scales as numbers of steps from the stated scales.
struct ScaleSteps : ErrorOctaves {
  int white = 0;
  auto operator<=>(const ScaleSteps&) const = default;
};

/// Evidence for a scale.
struct ScaleEvidence {
  double errors_nats = 0.0;  ///< nats, without any effect
  double total_nats = 0.0;   ///< nats, with the likeliest effect, or without if that is likelier
  JointScore score;
};

/// Finds the likeliest scale of the errors. There may be two local maxima: errors without effects,
/// and errors near the stated scale with an effect.
class ScaleSearch {
 public:
  ScaleSearch(const TimeCorrelatedErrorModel& errors, const Library& library, double sigma0)
      : errors_(errors), library_(library), sigma0_(std::max(1.0, sigma0)) {}

  ErrorScale Likeliest() {
    const ScaleSteps noisy{{}, MaxWhiteSteps()};
    const ScaleSteps alone = Climb(noisy, &ScaleEvidence::errors_nats);
    for (const ScaleSteps start : {ScaleSteps{}, noisy, alone}) {
      const ScaleSteps top = Climb(start, &ScaleEvidence::total_nats);
      if (At(top).total_nats > At(likeliest_).total_nats) likeliest_ = top;
    }
    return ToErrorScale(likeliest_);
  }

  /// Returns the score of the effects under errors of the likeliest scale.
  const JointScore& score() { return At(likeliest_).score; }

 private:
  ErrorScale ToErrorScale(const ScaleSteps& steps) const {
    return steps.Scale(std::pow(sigma0_, static_cast<double>(steps.white) / kWhiteSteps));
  }

  const ScaleEvidence& At(const ScaleSteps& steps) {
    const auto known = known_.find(steps);
    if (known != known_.end()) return known->second;
    TimeCorrelatedErrorModel::ScaleSolution at = errors_.At(ToErrorScale(steps));
    ScaleEvidence evidence;
    evidence.errors_nats = at.log_likelihood + steps.LogPrior();
    double effect_nats = 0.0, effects = 0.0;
    for (const Hypothesis& hypothesis : library_.hypotheses) {
      if (!hypothesis.id) continue;
      effect_nats = std::max(effect_nats, LogEvidence(hypothesis, at.score));
      effects += 1.0;
    }
    evidence.total_nats =
        evidence.errors_nats + std::max(0.0, effect_nats - std::log(effects / kFamilyLevel));
    evidence.score = std::move(at.score);
    return known_.emplace(steps, std::move(evidence)).first->second;
  }

  /// Climbs from a start to a scale that no neighbour exceeds.
  ScaleSteps Climb(const ScaleSteps& start, double ScaleEvidence::*height) {
    return ClimbGrid(start,
                     {{&ScaleSteps::position, kMaxOctaves},
                      {&ScaleSteps::attitude, kMaxOctaves},
                      {&ScaleSteps::white, MaxWhiteSteps()}},
                     [&](const ScaleSteps& steps) { return At(steps).*height; });
  }

  int MaxWhiteSteps() const { return sigma0_ > 1.0 ? kWhiteSteps : 0; }

  const TimeCorrelatedErrorModel& errors_;
  const Library& library_;
  double sigma0_;
  ScaleSteps likeliest_;
  std::map<ScaleSteps, ScaleEvidence> known_;
};

/// Returns the sigmas of the boresight without the contribution of the effects, which the reliable
/// sigmas may contain.
Vector3d SigmaWithoutEffects(const TimeCorrelatedErrorModel& errors, const ErrorScale& scale,
                             const GaussHelmertCalibration& calibration) {
  const Matrix3d covariance = errors.BoresightCovariance(scale) + calibration.constant_rad2;
  return covariance.diagonal().cwiseSqrt().cwiseMin(calibration.boresight.sigma_rad());
}

}  // namespace

GaussHelmertEffects FindEffects(const Flight& flight, const std::vector<StripInterval>& strips,
                                const GaussHelmertCalibration& calibration) {
  const LinearPairs pairs = LinearisePairs(flight, calibration);
  const LidarConfig& lidar = *flight.config.lidar;
  Library library = MakeScannerHypotheses(flight, pairs.ends);
  const Hypothesis by_angle = LaserByScanAngle(lidar, FindScanAngleRange(lidar, pairs.ends));
  library.Add(by_angle, MakePairColumns(by_angle, pairs.ends));
  const TimeCorrelatedErrorModel errors(pairs.rows, strips, pairs.error_sqrt, pairs.prior,
                                        library.blocks);
  ScaleSearch search(errors, library, calibration.figures.sigma0);
  const ErrorScale scale = search.Likeliest();
  TestFamily family{static_cast<double>(library.hypotheses.size()),
                    SigmaWithoutEffects(errors, scale, calibration), true};
  const UnmodelledPrior prior = MakeUnmodelledPrior(flight.config);
  const UnmodelledUnknowns unmodelled(library, prior, search.score());
  GaussHelmertEffects out;
  if (!unmodelled.empty()) {
    UnmodelledEffects& effects = out.unmodelled.emplace();
    // The adjustment takes the trajectory as given, so that its residuals are not those of the
    // estimates. The angles stay, and the covariance has the whole prior.
    effects.covariance_rad2 = unmodelled.PriorCovariance();
    effects.contributions = unmodelled.Contributions({0}, false);
    family.watched_sigma =
        (family.watched_sigma.cwiseAbs2() + effects.covariance_rad2.diagonal()).cwiseSqrt();
  }
  const ScoreSelection selection = SelectByScores(library, unmodelled.Conditioned(), family);
  out.effects = selection.effects;
  SetPriorSigmas(prior, selection.chosen, &out.effects);
  out.discrepancies = CheckDiscrepancies(library, selection.left, kNoExcess, family);
  const Eigen::VectorXd present = unmodelled.EstimateBeside(selection.joint) + selection.joint;
  if (!present.isZero(0.0)) out.share_left = errors.ResidualShare(present);
  return out;
}

}  // namespace dn::diagnosis_internal
