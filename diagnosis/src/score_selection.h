#pragma once

#include <dn/adjustment/checks.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "evidence.h"
#include "hypothesis.h"
#include "hypothesis_evidence.h"

namespace dn::diagnosis_internal {

/// Effects that are selected forward by their scores, without solving again.
struct ScoreSelection {
  std::vector<EffectCheck> effects;        ///< in the order found
  std::vector<HypothesisEvidence> chosen;  ///< the same, with joint estimates
  std::vector<ScoreTest> tests;            ///< the tests that found them
  /// Joint estimates of all of them, SI; one value per component of the score, 0 for all others.
  Eigen::VectorXd joint;
  JointScore left;  ///< the score after they have become unknowns
};

/// Selects the likeliest significant effect of the table, up to four times, each time with the
/// selected ones as unknowns. Then estimates all of them jointly. `score` is that of the library.
ScoreSelection SelectByScores(const Library& library, const JointScore& score,
                              const TestFamily& family);

/// Returns a selection with some of the effects of another, estimated again. `kept` are their
/// indices in ascending order. `score` is the one that was selected from.
ScoreSelection Keep(const ScoreSelection& selection, const std::vector<std::size_t>& kept,
                    const JointScore& score, const TestFamily& family);

/// Tests the unmodelled discrepancies of the library after the found effects have become unknowns;
/// `left` is the score with them. `excess` is the noise variance over the stated one. Leaves out
/// discrepancies that act on no factor, or that the unknowns absorb.
std::vector<DiscrepancyCheck> CheckDiscrepancies(const Library& library, const JointScore& left,
                                                 double excess, const TestFamily& family);

}  // namespace dn::diagnosis_internal
