#include "effect_screen.h"

#include <dn/report/distributions.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "model_findings.h"

namespace dn::internal {
namespace {

constexpr std::size_t kMaxSelectedEffects = 4;

class EffectScreener {
 public:
  EffectScreener(const std::vector<CandidateEffect>& candidates, const JointScore& score,
                 const ScreenOptions& options)
      : candidates_(candidates), score_(score), options_(options) {}

  EffectScreen Run() {
    JointScore& left = out_.beside = score_;
    while (out_.chosen.size() < kMaxSelectedEffects) {
      const std::optional<std::size_t> best = Likeliest(left);
      if (!best) break;
      EffectCheck effect = Describe(left, *best);
      JointScore given = ConditionOnComponents(left, left.Components(*best));
      effect.inseparable_from = AlsoExplain(left, given, *best, effect.log_evidence);
      out_.chosen.push_back(*best);
      out_.effects.push_back(std::move(effect));
      left = std::move(given);
    }
    EstimateTogether();
    return std::move(out_);
  }

 private:
  double ForFamily(double p_value) const { return std::min(1.0, p_value * options_.tests); }

  double InSigmas(const Eigen::VectorXd& move) const {
    return move.cwiseQuotient(options_.watched_sigma).cwiseAbs().maxCoeff();
  }

  double PValue(const JointScore& score, std::size_t k) const {
    const ScoreTest test = TestJointly(score, score.Components(k));
    return test.dof > 0 ? ForFamily(ChiSquareTail(test.statistic, test.dof)) : 1.0;
  }

  /// Returns the significant candidate with the most evidence, if there is one.
  std::optional<std::size_t> Likeliest(const JointScore& score) const {
    std::optional<std::size_t> best;
    double most = 0.0;
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      if (std::find(out_.chosen.begin(), out_.chosen.end(), k) != out_.chosen.end()) continue;
      if (PValue(score, k) > kFamilyLevel) continue;
      const double evidence = LogEvidence(score, score.Components(k), candidates_[k].typical);
      if (best && evidence <= most) continue;
      best = k;
      most = evidence;
    }
    return best;
  }

  EffectCheck Describe(const JointScore& score, std::size_t k) const {
    const CandidateEffect& candidate = candidates_[k];
    EffectCheck effect;
    effect.name = candidate.name;
    effect.unit = candidate.unit;
    effect.remedy = candidate.remedy;
    effect.p_value = PValue(score, k);
    effect.log_evidence = LogEvidence(score, score.Components(k), candidate.typical);
    return effect;
  }

  /// Returns the names of effects that are nearly as likely and no longer significant if `chosen`
  /// is estimated.
  std::vector<std::string> AlsoExplain(const JointScore& score, const JointScore& given,
                                       std::size_t chosen, double evidence) const {
    std::vector<std::string> names;
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      const std::string& name = candidates_[k].name;
      if (k == chosen || name == candidates_[chosen].name) continue;
      if (LogEvidence(score, score.Components(k), candidates_[k].typical) <
          evidence - kEquallyLikelyNats) {
        continue;
      }
      if (PValue(given, k) <= kFamilyLevel) continue;
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    return names;
  }

  /// Estimates all found effects jointly, and computes the shift by each of them.
  void EstimateTogether() {
    std::vector<Eigen::Index> components;
    for (const std::size_t k : out_.chosen) {
      for (const Eigen::Index c : score_.Components(k)) components.push_back(c);
    }
    if (components.empty()) return;
    const ScoreTest test = TestJointly(score_, components);
    Eigen::VectorXd usual(test.estimate.size());
    Eigen::Index at = 0;
    for (const std::size_t k : out_.chosen) {
      const Eigen::VectorXd& typical = candidates_[k].typical;
      usual.segment(at, typical.size()) = typical;
      at += typical.size();
    }
    const Eigen::VectorXd shrunk = ShrunkEstimate(score_, components, usual);
    at = 0;
    for (std::size_t e = 0; e < out_.chosen.size(); ++e) {
      const CandidateEffect& candidate = candidates_[out_.chosen[e]];
      const Eigen::Index q = candidate.typical.size();
      EffectCheck& effect = out_.effects[e];
      effect.estimate = candidate.per_si * test.estimate.segment(at, q);
      effect.sigma =
          candidate.per_si * test.covariance.diagonal().segment(at, q).cwiseMax(0.0).cwiseSqrt();
      const Eigen::VectorXd move =
          score_.shift(Eigen::all, score_.Components(out_.chosen[e])) * shrunk.segment(at, q);
      effect.max_shift_sigmas = InSigmas(move);
      if (options_.of_boresight) effect.boresight_rad = move;
      at += q;
    }
    out_.joint = test.estimate;
  }

  const std::vector<CandidateEffect>& candidates_;
  const JointScore& score_;
  const ScreenOptions& options_;
  EffectScreen out_;
};

}  // namespace

double LogEvidence(const JointScore& score, const std::vector<Eigen::Index>& components,
                   const Eigen::VectorXd& typical) {
  return SizeAveragedEvidence(score.A(components, components), typical)
      .LogEvidence(score.s(components));
}

Eigen::VectorXd ShrunkEstimate(const JointScore& score, const std::vector<Eigen::Index>& components,
                               const Eigen::VectorXd& typical) {
  Eigen::MatrixXd A = score.A(components, components);
  A.diagonal() += (kMaxPerTypical * typical).cwiseAbs2().cwiseInverse();
  return -A.ldlt().solve(score.s(components));
}

std::optional<DiscrepancyCheck> CheckDiscrepancy(const CandidateEffect& departure,
                                                 const JointScore& beside,
                                                 const std::vector<Eigen::Index>& components,
                                                 double excess, const ScreenOptions& options) {
  const ScoreTest test = TestJointly(beside, components);
  if (test.dof == 0) return std::nullopt;
  const Eigen::VectorXd move =
      beside.shift(Eigen::all, components) * ShrunkEstimate(beside, components, departure.typical);
  DiscrepancyCheck check;
  check.name = departure.name;
  check.statistic = test.statistic / excess;
  check.dof = test.dof;
  check.p_value = std::min(1.0, options.tests * ChiSquareTail(check.statistic, test.dof));
  check.max_shift_sigmas = move.cwiseQuotient(options.watched_sigma).cwiseAbs().maxCoeff();
  if (options.of_boresight) check.boresight_rad = move;
  return check;
}

EffectScreen ScreenEffects(const std::vector<CandidateEffect>& candidates, const JointScore& score,
                           const ScreenOptions& options) {
  return EffectScreener(candidates, score, options).Run();
}

}  // namespace dn::internal
