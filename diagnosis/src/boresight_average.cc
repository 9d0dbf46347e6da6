#include "boresight_average.h"

#include <dn/effects/effect_table.h>
#include <dn/rotation.h>

#include <vector>

#include "unmodelled.h"

namespace dn::diagnosis_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Returns the left rotation that takes the angles `from` to the angles `to`.
Vector3d Rotation(const Vector3d& from, const Vector3d& to) {
  return Log(Quaterniond(Exp(to) * Exp(from).conjugate()));
}

Vector3d Rotated(const Vector3d& by, const Vector3d& angles_rad) {
  return Log(Quaterniond(Exp(by) * Exp(angles_rad)));
}

/// Returns whether the screen has columns for a hypothesis.
bool HasColumns(const HypothesisEvidence& effect) {
  if (!effect.physical()) return true;
  const EffectSpec& spec = EffectRow(*effect.id);
  return spec.fixed() || spec.process();
}

/// Weighted mean and covariance of boresights near a reference.
class BoresightMixture {
 public:
  explicit BoresightMixture(const BoresightEstimate& reference) : reference_(reference) {}

  /// Adds a boresight that differs from the reference by a left rotation.
  void Add(double weight, const Vector3d& rotation, const Matrix3d& covariance) {
    parts_.push_back({weight, rotation, covariance});
  }

  BoresightEstimate Result() const {
    double sum = 0.0;
    Vector3d mean = Vector3d::Zero();
    for (const Part& part : parts_) {
      sum += part.weight;
      mean += part.weight * part.rotation;
    }
    if (!(sum > 0.0)) return reference_;
    mean /= sum;
    Matrix3d covariance = Matrix3d::Zero();
    for (const Part& part : parts_) {
      const Vector3d off = part.rotation - mean;
      covariance += part.weight / sum * (part.covariance + off * off.transpose());
    }
    return {Rotated(mean, reference_.angles_rad), covariance};
  }

 private:
  struct Part {
    double weight;
    Vector3d rotation;
    Matrix3d covariance;
  };

  const BoresightEstimate& reference_;
  std::vector<Part> parts_;
};

/// Adds the hypotheses of one set to a mixture, with a common factor of their weights.
class SetOfHypotheses {
 public:
  SetOfHypotheses(const CompetingHypotheses& set, const BoresightEstimate& of_fit,
                  BoresightMixture* mixture)
      : set_(set),
        of_fit_(of_fit),
        own_(FindByName(set.competing_effects, set.effect)),
        mixture_(*mixture) {}

  void Add(double factor) {
    if (set_.competing_effects.empty()) return;
    if (own_ != nullptr) AddWithout(factor * set_.posterior.nothing);
    for (std::size_t k = 0; k < set_.competing_effects.size(); ++k) {
      const HypothesisEvidence& one = set_.competing_effects[k];
      if (!one.boresight) continue;
      if (&one != own_) AddWith(factor * set_.posterior.own[k], one, 0.0);
      AddWith(factor * set_.posterior.resembling[k], one, set_.differing[k]);
    }
  }

 private:
  void AddWithout(double weight) {
    if (!own_->boresight) return;
    mixture_.Add(weight, FromOwn(own_->boresight->without),
                 own_->boresight->without.covariance_rad2);
  }

  void AddWith(double weight, const HypothesisEvidence& one, double differing_share) {
    const Vector3d shift =
        Rotation(one.boresight->without.angles_rad, one.boresight->with.angles_rad);
    mixture_.Add(
        weight, FromOwn(one.boresight->with),
        one.boresight->with.covariance_rad2 + differing_share * (shift * shift.transpose()));
  }

  /// Returns the difference from the fit. It is that from the named effect, both to first order, so
  /// that the second order of a large effect cancels.
  Vector3d FromOwn(const BoresightEstimate& boresight) const {
    const bool known = own_ != nullptr && own_->boresight;
    return Rotation(known ? own_->boresight->with.angles_rad : of_fit_.angles_rad,
                    boresight.angles_rad);
  }

  const CompetingHypotheses& set_;
  const BoresightEstimate& of_fit_;
  const HypothesisEvidence* own_;
  BoresightMixture& mixture_;
};

double OwnProbability(const CompetingHypotheses& set) {
  for (std::size_t k = 0; k < set.competing_effects.size(); ++k) {
    if (set.competing_effects[k].name == set.effect) return set.posterior.own[k];
  }
  return 0.0;
}

}  // namespace

void SetBoresights(const Screen& screen, const UnmodelledPrior& prior,
                   const BoresightEstimate& of_fit, ExtendedFit* fit) {
  const UnmodelledUnknowns unknowns(screen.library(), prior, screen.score());
  BoresightEstimate without = of_fit;
  if (!unknowns.empty()) {
    without.angles_rad = Rotated(unknowns.Correction(), of_fit.angles_rad);
    without.covariance_rad2 += unknowns.AddedCovariance();
  }
  const JointScore score = unknowns.Conditioned();
  for (HypothesisEvidence& effect : fit->effects) {
    effect.boresight = {without, without};
    if (!HasColumns(effect)) continue;
    const SizeAveragedEvidence form(SelectInformation(effect, score), effect.typical);
    const LinearMoments shift =
        form.Moments(SelectScore(effect, score, score.s), SelectShift(effect, score));
    BoresightEstimate& with = effect.boresight->with;
    with.angles_rad = Rotated(-shift.mean, without.angles_rad);
    with.covariance_rad2 += shift.covariance;
  }
  fit->boresight = without;
}

BoresightEstimate AverageBoresight(const BoresightEstimate& of_fit,
                                   const std::vector<CompetingHypotheses>& named,
                                   const CompetingHypotheses& further) {
  BoresightMixture mixture(of_fit);
  double all_named = 1.0;
  for (const CompetingHypotheses& set : named) all_named *= OwnProbability(set);
  mixture.Add(all_named * further.posterior.nothing, Vector3d::Zero(), of_fit.covariance_rad2);
  SetOfHypotheses(further, of_fit, &mixture).Add(all_named);
  for (std::size_t k = 0; k < named.size(); ++k) {
    double others = further.posterior.nothing;
    for (std::size_t l = 0; l < named.size(); ++l) {
      if (l != k) others *= OwnProbability(named[l]);
    }
    SetOfHypotheses(named[k], of_fit, &mixture).Add(others);
  }
  return mixture.Result();
}

}  // namespace dn::diagnosis_internal
