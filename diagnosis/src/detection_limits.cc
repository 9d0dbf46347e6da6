#include "detection_limits.h"

#include <dn/effects/effect_table.h>
#include <dn/sim/random.h>
#include <dn/symmetric_eigen.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "detectability.h"
#include "evidence.h"
#include "semidefinite_root.h"

namespace dn::diagnosis_internal {
namespace {

constexpr double kNamed = 0.8;
constexpr double kLargest = 100.0;  // in multiples of the typical size
constexpr double kStep = 1.5;
constexpr int kFlights = 40;
// Hypotheses that mimic less of an effect than this are never named in its place.
constexpr double kMimics = 0.2;

/// The part of an effect that other hypotheses can absorb.
class Mimicry {
 public:
  explicit Mimicry(const Screen& screen)
      : screen_(screen), inverse_(screen.library().hypotheses.size()) {}

  /// Returns c^T A^+ c of a hypothesis, where c is its cross information with the effect.
  double Absorbed(std::size_t hypothesis, const Eigen::VectorXd& c) {
    Eigen::MatrixXd& inverse = inverse_[hypothesis];
    if (inverse.size() == 0)
      inverse =
          TestHypothesis(screen_.library().hypotheses[hypothesis], screen_.score()).covariance;
    return c.dot(inverse * c);
  }

 private:
  const Screen& screen_;
  std::vector<Eigen::MatrixXd> inverse_;  // one per hypothesis, computed on demand
};

/// Simulates the scores of an effect and its competitors, and the decision that is based on them.
class NamingTrials {
 public:
  NamingTrials(const Screen& screen, Mimicry* mimicry, std::size_t truth,
               const Eigen::VectorXd& direction, double threshold_nats)
      : screen_(screen),
        mimicry_(*mimicry),
        direction_(direction),
        threshold_nats_(threshold_nats) {
    competitors_.push_back(truth);
    FindCompetitors();
    Factor();
  }

  /// Returns the fraction of flights in which an effect of this size is named. Counts in `instead`
  /// the other names that are given.
  double Named(double size, std::uint64_t seed, std::map<std::string, int>* instead) const {
    const std::string& truth = Competitor(0).name;
    Random random(seed, "limits/" + truth);
    const Eigen::VectorXd mean = size * cross_ * direction_;
    int named = 0;
    for (int flight = 0; flight < kFlights; ++flight) {
      Eigen::VectorXd noise(root_.cols());
      for (Eigen::Index k = 0; k < noise.size(); ++k) noise[k] = random.Normal();
      const std::string name = Best(mean + root_ * noise);
      if (name == truth) {
        ++named;
      } else if (!name.empty()) {
        ++(*instead)[name];
      }
    }
    return static_cast<double>(named) / kFlights;
  }

 private:
  const Hypothesis& Competitor(std::size_t k) const {
    return screen_.library().hypotheses[competitors_[k]];
  }

  /// Finds the hypothesis of every other family that mimics the effect best.
  void FindCompetitors() {
    const Hypothesis& truth = Competitor(0);
    const Eigen::MatrixXd A = SelectInformation(truth, screen_.score());
    const double lambda = direction_.dot(A * direction_);
    for (const EffectFamily& family : screen_.families()) {
      if (family.name == truth.name) continue;
      double most = 0.0;
      std::size_t best = family.first;
      const std::size_t stride = std::max<std::size_t>(1, (family.past - family.first) / 40);
      for (std::size_t k = family.first; k < family.past; k += stride) {
        const Hypothesis& other = screen_.library().hypotheses[k];
        const Eigen::VectorXd c = SelectInformation(other, truth, screen_.score()) * direction_;
        const double mimicked = mimicry_.Absorbed(k, c) / std::max(lambda, 1e-300);
        if (mimicked > most) {
          most = mimicked;
          best = k;
        }
      }
      if (most > kMimics) competitors_.push_back(best);
    }
  }

  /// Computes the root of the joint covariance of the scores, and their change per unit of the
  /// effect.
  void Factor() {
    const JointScore& score = screen_.score();
    first_.push_back(0);
    for (std::size_t k = 0; k < competitors_.size(); ++k) {
      first_.push_back(first_.back() + Competitor(k).typical.size());
    }
    Eigen::MatrixXd joint(first_.back(), first_.back());
    Eigen::VectorXd signature(first_.back());
    for (std::size_t a = 0; a < competitors_.size(); ++a) {
      signature.segment(first_[a], first_[a + 1] - first_[a]) =
          SelectSignature(Competitor(a), score);
      for (std::size_t b = 0; b < competitors_.size(); ++b) {
        joint.block(first_[a], first_[b], first_[a + 1] - first_[a], first_[b + 1] - first_[b]) =
            SelectInformation(Competitor(a), Competitor(b), score);
      }
    }
    // An effect that is present enters the residuals with a negative sign: the score decreases.
    cross_ = -joint.leftCols(first_[1]);
    root_ = SemidefiniteRoot(joint, kAbsorbedShare * signature);
  }

  std::string Best(const Eigen::VectorXd& s) const {
    std::string best;
    double most = threshold_nats_;
    for (std::size_t k = 0; k < competitors_.size(); ++k) {
      const double evidence = screen_.form(competitors_[k])
                                  .LogEvidence(s.segment(first_[k], first_[k + 1] - first_[k]));
      if (evidence <= most) continue;
      most = evidence;
      best = Competitor(k).name;
    }
    return best;
  }

  const Screen& screen_;
  Mimicry& mimicry_;
  Eigen::VectorXd direction_;
  double threshold_nats_;
  std::vector<std::size_t> competitors_;  // indices of hypotheses, the effect itself first
  std::vector<Eigen::Index> first_;
  Eigen::MatrixXd cross_, root_;
};

/// Returns the best-determined direction of the components scaled by their typical sizes, SI.
Eigen::VectorXd BestDirection(const Hypothesis& hypothesis, const Eigen::MatrixXd& A) {
  const SymmetricEigen eigen(hypothesis.typical.asDiagonal() * A * hypothesis.typical.asDiagonal());
  const Eigen::VectorXd best = eigen.vectors.col(eigen.vectors.cols() - 1);
  return hypothesis.typical.cwiseProduct(best);
}

/// Sets the minimal identifiable size, and the effects that are named instead at the largest size
/// that was tried. `unit` is the reported size per unit of the direction.
void FindIdentifiable(const NamingTrials& trials, double unit, std::uint64_t seed,
                      DetectionLimit* limit) {
  std::map<std::string, int> instead;
  const double start = std::clamp(limit->minimal_detectable / unit, 1.0 / kLargest, kLargest);
  double below = 0.0;  // fraction named at the previous size
  for (double size = 0.5 * start; size <= kLargest * std::max(1.0, start); size *= kStep) {
    instead.clear();
    const double named = trials.Named(size, seed, &instead);
    if (named >= kNamed) {
      const bool first = size == 0.5 * start;
      const double back = first ? 0.0 : (named - kNamed) / (named - below);
      limit->minimal_identifiable = size * std::pow(kStep, -back) * unit;
      break;
    }
    below = named;
  }
  for (const auto& [name, times] : instead) {
    if (times >= kFlights / 10 && FindEffect(name) != nullptr) {
      limit->inseparable_from.push_back(name);
    }
  }
}

DetectionLimit ComputeLimits(const Screen& screen, Mimicry* mimicry, const EffectFamily& family,
                             double threshold_nats, std::uint64_t seed) {
  const std::size_t middle = family.first + (family.past - family.first) / 2;
  const Hypothesis& hypothesis = screen.library().hypotheses[middle];
  const JointScore& score = screen.score();
  const Eigen::MatrixXd A = SelectInformation(hypothesis, score);
  const Eigen::VectorXd direction = BestDirection(hypothesis, A);
  // The size of an effect is that of its largest component.
  const double unit = hypothesis.per_si * direction.cwiseAbs().maxCoeff();
  const double detectable = MinimalDetectableBias(
      direction.dot(A * direction), SelectSignature(hypothesis, score).dot(direction.cwiseAbs2()));
  DetectionLimit limit;
  limit.effect = hypothesis.name;
  limit.unit = hypothesis.unit;
  limit.detectable_by_component = hypothesis.per_si * MinimalDetectableBiases(hypothesis, score);
  limit.minimal_detectable = detectable * unit;
  if (std::isfinite(detectable) && score.shift.rows() == 3) {
    limit.boresight_rad = detectable * SelectShift(hypothesis, score) * direction;
  }
  const NamingTrials trials(screen, mimicry, middle, direction, threshold_nats);
  FindIdentifiable(trials, unit, seed, &limit);
  return limit;
}

}  // namespace

std::vector<DetectionLimit> ComputeDetectionLimits(const Screen& screen, double threshold_nats,
                                                   std::uint64_t seed) {
  std::vector<DetectionLimit> limits;
  Mimicry mimicry(screen);
  for (const EffectFamily& family : screen.families()) {
    const bool process = screen.library().hypotheses[family.first].tau_s.has_value();
    if (!family.id || process) continue;
    limits.push_back(ComputeLimits(screen, &mimicry, family, threshold_nats, seed));
  }
  std::stable_sort(limits.begin(), limits.end(), [](const auto& a, const auto& b) {
    return a.boresight_rad.norm() > b.boresight_rad.norm();
  });
  return limits;
}

}  // namespace dn::diagnosis_internal
