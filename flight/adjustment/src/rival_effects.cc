#include "rival_effects.h"

#include <dn/effects/effect_table.h>
#include <dn/report/distributions.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "effect_screen.h"
#include "model_findings.h"

namespace dn::internal {
namespace {

/// One unknown of the network, and the solution without estimating it.
class Removed {
 public:
  Removed(const FlightNetwork& network, const Marginals& marginals, const WatchedUnknowns& watched,
          BlockId unknown)
      : record_(network.net().block(unknown)),
        estimate_(Eigen::VectorXd::Map(record_.value.get(), record_.kind.stored_size) -
                  AssumedValue(network.flight(), record_.name)),
        information_(marginals.Covariance(unknown).llt().solve(
            Eigen::MatrixXd::Identity(estimate_.size(), estimate_.size()))) {
    Eigen::MatrixXd cross(watched.sigma.size(), estimate_.size());
    Eigen::Index row = 0;
    for (const BlockId block : watched.blocks) {
      const Eigen::MatrixXd C = marginals.Covariance(block, unknown);
      cross.middleRows(row, C.rows()) = C;
      row += C.rows();
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

/// A candidate that replaces an unknown.
struct Replacement {
  double log_evidence = 0.0;
  Eigen::VectorXd move;  ///< shift of the watched unknowns
};

Replacement ReplaceUnknown(const CandidateEffect& candidate,
                           const std::vector<Eigen::Index>& components, const JointScore& score,
                           const Removed& removed, Eigen::Index first_row) {
  const Eigen::MatrixXd Z_k =
      score.shift(Eigen::seqN(first_row, removed.estimate().size()), components);
  const Eigen::MatrixXd A_kj = removed.information() * Z_k;
  const Eigen::VectorXd s = score.s(components) - A_kj.transpose() * removed.estimate();
  Eigen::MatrixXd A = score.A(components, components);
  A += Z_k.transpose() * A_kj;
  Replacement out;
  out.log_evidence = SizeAveragedEvidence(A, candidate.typical).LogEvidence(s);
  A.diagonal() += (kMaxPerTypical * candidate.typical).cwiseAbs2().cwiseInverse();
  const Eigen::VectorXd estimate = -A.ldlt().solve(s);
  const Eigen::MatrixXd Z_x = score.shift(Eigen::seqN(0, removed.shift().rows()), components);
  out.move = removed.shift() * (removed.estimate() - Z_k * estimate) - Z_x * estimate;
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

std::vector<CompetingEffectCheck> FindCompetingEffects(
    const FlightNetwork& network, const Marginals& marginals,
    const std::vector<CandidateEffect>& candidates, const JointScore& score,
    const WatchedUnknowns& watched, const std::vector<BlockId>& unknowns, double tests) {
  std::vector<CompetingEffectCheck> competing_effects;
  Eigen::Index first_row = watched.sigma.size();
  for (const BlockId unknown : unknowns) {
    const Removed removed(network, marginals, watched, unknown);
    const Eigen::Index row = first_row;
    first_row += removed.estimate().size();
    if (removed.PValue() * tests > kFamilyLevel) continue;
    const double own = removed.LogEvidence();
    std::optional<CompetingEffectCheck> farthest;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      if (candidates[k].name == removed.name()) continue;
      const Replacement other =
          ReplaceUnknown(candidates[k], score.Components(k), score, removed, row);
      if (other.log_evidence < own - kEquallyLikelyNats) continue;
      const double max_shift_sigmas = other.move.cwiseQuotient(watched.sigma).cwiseAbs().maxCoeff();
      if (farthest && max_shift_sigmas <= farthest->max_shift_sigmas) continue;
      farthest = {removed.name(), candidates[k].name, other.log_evidence - own,
                  Eigen::Vector3d::Zero(), max_shift_sigmas};
      if (watched.of_boresight) farthest->boresight_rad = other.move;
    }
    if (farthest) competing_effects.push_back(std::move(*farthest));
  }
  return competing_effects;
}

}  // namespace dn::internal
