#include "pair_fit.h"

#include <dn/solvers/score_test.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "climb_grid.h"
#include "joint_estimate.h"

namespace dn::diagnosis_internal {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr EffectId kNoise = EffectId::kP2pNoiseScale;
// Prior of the pairs' noise: within a factor e of its stated size.
constexpr double kLnNoiseSigma = 1.0;
constexpr double kLnNoiseStep = 0.02;
constexpr int kNoisePasses = 4;

/// Returns the Occam factor of the evidence for scaled noise whose ln(ratio) is known to sigma.
double NoisePrior(double ln_ratio, double sigma) {
  const double in_sigmas = ln_ratio / kLnNoiseSigma;
  return std::log(std::min(1.0, sigma / kLnNoiseSigma)) - 0.5 * in_sigmas * in_sigmas;
}

}  // namespace

/// Likelihood and screen at one error scale, with the chosen effects among the unknowns.
struct PairFitter::Height {
  double of_errors = 0.0;  ///< log likelihood plus log prior
  Screen screen;
  std::vector<HypothesisEvidence> effects;  ///< in the order of the families
};

/// Search over all error scales for one set of chosen effects.
class PairFitter::Search {
 public:
  Search(PairFitter* fitter, const std::vector<HypothesisEvidence>& chosen)
      : fitter_(*fitter), chosen_(chosen) {}

  PairFit Run() {
    const NoiseRatio noise = FindNoise(Climb({}, 1.0, std::nullopt));
    const double most = Contains(chosen_, kNoise) ? noise.ratio : std::min(noise.ratio, 1.0);
    white_ = Contains(chosen_, kNoise) ? most : std::max(most, fitter_.min_white_);
    const ErrorOctaves top = Climb({}, white_, std::nullopt);
    base_ = At(top, white_).of_errors;
    PairFit out;
    const Height& at_top = At(top, white_);
    out.scale = top.Scale(white_);
    out.chi2 = fitter_.At(top, white_).chi2;
    out.larger_errors_nats = base_ - At({}, white_).of_errors;
    out.screen = std::make_unique<Screen>(at_top.screen);
    out.with_stated_errors = std::make_unique<Screen>(At({}, white_).screen);
    out.chi2_with_stated_errors = fitter_.At({}, white_).chi2;
    for (std::size_t family = 0; family < at_top.effects.size(); ++family) {
      out.effects.push_back(Judge(family, top));
    }
    if (fitter_.with_noise_scale_) out.effects.push_back(JudgeNoise(top, noise));
    std::erase_if(out.effects, [&](const HypothesisEvidence& other) {
      return other.id && Contains(chosen_, *other.id);
    });
    SortByEvidence(&out.effects);
    EstimateChosen(top, &out);
    return out;
  }

 private:
  const Height& At(const ErrorOctaves& octaves, double white) {
    const auto key = std::make_pair(octaves, white);
    const auto known = heights_.find(key);
    if (known != heights_.end()) return known->second;
    const TimeCorrelatedErrorModel::ScaleSolution& at = fitter_.At(octaves, white);
    const JointColumns columns = CombineFixed(chosen_, at.score);
    Height height{at.log_likelihood + octaves.LogPrior(),
                  Screen(fitter_.library_.library, ConditionOn(at.score, columns.T)),
                  {}};
    if (columns.T.cols() > 0) {
      const SizeAveragedEvidence form(columns.Information(at.score), columns.typical);
      height.of_errors += form.LogEvidence(columns.Score(at.score));
    }
    height.effects = height.screen.EffectsInOrder();
    return heights_.emplace(key, std::move(height)).first->second;
  }

  double HeightAt(const ErrorOctaves& octaves, double white, std::optional<std::size_t> family) {
    const Height& at = At(octaves, white);
    return at.of_errors + (family ? at.effects[*family].log_evidence : 0.0);
  }

  /// Climbs to the likeliest scale of the trajectory errors, with a family of effects or without.
  ErrorOctaves Climb(const ErrorOctaves& start, double white, std::optional<std::size_t> family) {
    return ClimbGrid(
        start, {{&ErrorOctaves::position, kMaxOctaves}, {&ErrorOctaves::attitude, kMaxOctaves}},
        [&](const ErrorOctaves& octaves) { return HeightAt(octaves, white, family); });
  }

  HypothesisEvidence Judge(std::size_t family, const ErrorOctaves& of_errors) {
    ErrorOctaves best = Climb({}, white_, family);
    const ErrorOctaves other = Climb(of_errors, white_, family);
    if (HeightAt(other, white_, family) > HeightAt(best, white_, family)) best = other;
    HypothesisEvidence effect = At(best, white_).effects[family];
    effect.log_evidence = HeightAt(best, white_, family) - base_;
    const double by_evidence = std::exp(-std::max(0.0, effect.log_evidence));
    effect.p_value = std::min(1.0, std::max(effect.p_value * Families(), by_evidence));
    return effect;
  }

  double Families() { return static_cast<double>(At({}, white_).effects.size() + 1); }

  /// Most probable noise of the pairs as a ratio to its upper limit.
  struct NoiseRatio {
    double ratio = 1.0;
    double ln_sigma = 1.0;
  };

  /// Maximises the likelihood of ln(ratio) with Newton steps that start at the mean square.
  NoiseRatio FindNoise(const ErrorOctaves& octaves) {
    const auto height = [&](double ln_ratio) {
      return fitter_.At(octaves, std::exp(ln_ratio)).log_likelihood;
    };
    const double n = fitter_.observations_;
    double x = 0.5 * std::log(std::max(fitter_.At(octaves, 1.0).chi2, 1.0) / n);
    double curvature = 2.0 * n;
    for (int pass = 0; pass < kNoisePasses; ++pass) {
      const double low = height(x - kLnNoiseStep), high = height(x + kLnNoiseStep);
      const double bend = (2.0 * height(x) - low - high) / (kLnNoiseStep * kLnNoiseStep);
      if (!(bend > 0.0)) break;
      curvature = bend;
      const double step = 0.5 * (high - low) / (kLnNoiseStep * curvature);
      x += std::clamp(step, -1.0, 1.0);
      if (std::abs(step) < 0.1 / std::sqrt(curvature)) break;
    }
    return {std::exp(x), 1.0 / std::sqrt(curvature)};
  }

  HypothesisEvidence JudgeNoise(const ErrorOctaves& of_errors, const NoiseRatio& noise) {
    const ErrorOctaves top = Climb(of_errors, noise.ratio, std::nullopt);
    const double log_evidence = HeightAt(top, noise.ratio, std::nullopt) - base_ +
                                NoisePrior(std::log(noise.ratio / white_), noise.ln_sigma);
    const double of_pairs = noise.ratio / fitter_.min_white_;
    HypothesisEvidence effect = MakeEvidence(kNoise, log_evidence, VectorXd::Constant(1, of_pairs),
                                             VectorXd::Constant(1, noise.ln_sigma * of_pairs));
    effect.p_value = std::min(1.0, Families() * effect.p_value);
    return effect;
  }

  void EstimateChosen(const ErrorOctaves& top, PairFit* out) {
    out->chosen = chosen_;
    const JointScore& score = fitter_.At(top, white_).score;
    const JointColumns columns = CombineFixed(chosen_, score);
    if (columns.T.cols() == 0) return;
    const ScoreTest test = columns.Test(score);
    TakeJointEstimates(test, &out->chosen);
    for (HypothesisEvidence& effect : out->chosen) {
      if (EffectRow(*effect.id).fixed()) {
        effect.boresight_rad = SelectShift(effect, score) * effect.estimate;
      }
    }
    const MatrixXd shift = score.shift * columns.T;
    out->boresight_covariance_rad2 = shift * test.covariance * shift.transpose();
  }

  PairFitter& fitter_;
  const std::vector<HypothesisEvidence>& chosen_;
  double white_ = 1.0;
  double base_ = 0.0;
  std::map<std::pair<ErrorOctaves, double>, Height> heights_;
};

PairFitter::PairFitter(const PairLibrary& library, const LinearPairs& pairs,
                       const std::vector<StripInterval>& strips, bool with_noise_scale)
    : library_(library),
      errors_(pairs.rows, strips, pairs.error_sqrt, pairs.prior, library.blocks),
      with_noise_scale_(with_noise_scale),
      observations_(3.0 * static_cast<double>(pairs.rows.size())),
      min_white_(std::sqrt(pairs.pair_noise_share)) {}

PairFit PairFitter::Fit(const std::vector<HypothesisEvidence>& chosen) {
  return Search(this, chosen).Run();
}

double PairFitter::NoiseEvidence(double chi2) const {
  if (!with_noise_scale_) return -std::numeric_limits<double>::infinity();
  const double ratio = std::max(chi2, 1e-300) / observations_;
  return 0.5 * observations_ * (ratio - 1.0 - std::log(ratio)) +
         NoisePrior(0.5 * std::log(ratio), 1.0 / std::sqrt(2.0 * observations_));
}

const TimeCorrelatedErrorModel::ScaleSolution& PairFitter::At(const ErrorOctaves& octaves,
                                                              double white) {
  const auto key = std::make_pair(octaves, white);
  const auto known = known_.find(key);
  if (known != known_.end()) return known->second;
  return known_.emplace(key, errors_.At(octaves.Scale(white))).first->second;
}

}  // namespace dn::diagnosis_internal
