#include "competing_effects.h"

#include <dn/builder/beam_unknowns.h>
#include <dn/distributions.h>
#include <dn/effects/effect_table.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

/// One unknown of the network, and the solution without estimating it.
class Removed {
 public:
  Removed(const FlightNetwork& network, const Marginals& marginals,
          const std::vector<BlockId>& watched, BlockId unknown)
      : record_(network.net().block(unknown)),
        estimate_(Eigen::VectorXd::Map(record_.value.get(), record_.kind.stored_size) -
                  AssumedValue(network.flight(), record_.name)),
        information_(marginals.Covariance(unknown).llt().solve(
            Eigen::MatrixXd::Identity(estimate_.size(), estimate_.size()))) {
    const auto rows = 3 * static_cast<Eigen::Index>(watched.size());
    Eigen::MatrixXd cross(rows, estimate_.size());
    Eigen::Index row = 0;
    for (const BlockId block : watched) {
      const Eigen::MatrixXd C = marginals.Covariance(block, unknown);
      cross.middleRows<3>(row) = C;
      row += 3;
    }
    shift_ = -cross * information_;
  }

  const std::string& name() const { return record_.name; }
  const Eigen::VectorXd& estimate() const { return estimate_; }
  const Eigen::MatrixXd& information() const { return information_; }
  /// Returns the shift of the watched unknowns per unit of this unknown that is not estimated.
  const Eigen::MatrixXd& shift() const { return shift_; }

  double PValue() const {
    return ChiSquareTail(estimate_.dot(information_ * estimate_),
                         static_cast<double>(estimate_.size()));
  }
  double LogEvidence() const {
    return SizeAveragedEvidence(information_, TypicalInSi(*FindEffect(name())))
        .LogEvidence(-information_ * estimate_);
  }

 private:
  const BlockRecord& record_;
  Eigen::VectorXd estimate_;
  Eigen::MatrixXd information_, shift_;
};

/// A hypothesis that replaces an unknown.
struct Replacement {
  double log_evidence = 0.0;
  Eigen::VectorXd shift;  ///< of the watched unknowns
};

Replacement ReplaceUnknown(const Hypothesis& hypothesis, const JointScore& score,
                           const Removed& removed, Eigen::Index first_row) {
  const Eigen::MatrixXd Z = SelectShift(hypothesis, score);
  const Eigen::MatrixXd Z_k = Z.middleRows(first_row, removed.estimate().size());
  const Eigen::MatrixXd A_kj = removed.information() * Z_k;
  const Eigen::VectorXd s =
      SelectScore(hypothesis, score, score.s) - A_kj.transpose() * removed.estimate();
  const Eigen::MatrixXd A = SelectInformation(hypothesis, score) + Z_k.transpose() * A_kj;
  Replacement out;
  out.log_evidence = SizeAveragedEvidence(A, hypothesis.typical).LogEvidence(s);
  const Eigen::VectorXd estimate = ShrunkEstimate(A, s, hypothesis.typical);
  out.shift = removed.shift() * (removed.estimate() - Z_k * estimate) -
              Z.topRows(removed.shift().rows()) * estimate;
  return out;
}

}  // namespace

std::vector<BlockId> EffectUnknowns(const FlightNetwork& network) {
  std::vector<BlockId> unknowns;
  for (const EstimateEntry& entry : network.flight().config.estimate) {
    if (entry.unknown == "boresight" || FindEffect(entry.unknown) == nullptr) continue;
    const BlockId id = network.net().Find(entry.unknown);
    if (!network.net().block(id).held) unknowns.push_back(id);
  }
  return unknowns;
}

std::vector<BlockId> BeamBlocks(const FlightNetwork& network) {
  std::vector<BlockId> blocks;
  for (const EffectBlock& effect : network.calibration().effects()) {
    if (IsBeamUnknown(effect.name) && !network.net().block(effect.id).held) {
      blocks.push_back(effect.id);
    }
  }
  return blocks;
}

std::vector<CompetingEffectCheck> FindCompetingEffects(
    const FlightNetwork& network, const Marginals& marginals, const Library& library,
    const JointScore& score, const std::vector<BlockId>& watched,
    const std::vector<BlockId>& unknowns, const TestFamily& family) {
  std::vector<CompetingEffectCheck> competing_effects;
  Eigen::Index first_row = family.watched_sigma.size();
  for (const BlockId unknown : unknowns) {
    const Removed removed(network, marginals, watched, unknown);
    const Eigen::Index row = first_row;
    first_row += removed.estimate().size();
    if (family.FamilyWise(removed.PValue()) > kFamilyLevel) continue;
    const double own = removed.LogEvidence();
    std::optional<CompetingEffectCheck> farthest;
    for (const Hypothesis& hypothesis : library.hypotheses) {
      if (!hypothesis.id || hypothesis.name == removed.name()) continue;
      const Replacement other = ReplaceUnknown(hypothesis, score, removed, row);
      if (other.log_evidence < own - kEquallyLikelyNats) continue;
      const double max_shift_sigmas = family.InSigmas(other.shift);
      if (farthest && max_shift_sigmas <= farthest->max_shift_sigmas) continue;
      farthest = {removed.name(), hypothesis.name, other.log_evidence - own,
                  family.BoresightShift(other.shift), max_shift_sigmas};
    }
    if (farthest) competing_effects.push_back(std::move(*farthest));
  }
  return competing_effects;
}

}  // namespace dn::diagnosis_internal
