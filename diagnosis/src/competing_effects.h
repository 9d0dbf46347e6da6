#pragma once

#include <dn/adjustment/checks.h>
#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/score_test.h>

#include <vector>

#include "evidence.h"
#include "hypothesis.h"

namespace dn::diagnosis_internal {

/// Returns the estimated unknowns of a network that are effects of the table, without the
/// boresight.
std::vector<BlockId> EffectUnknowns(const FlightNetwork& network);

/// Returns the blocks with the corrections of beams.
std::vector<BlockId> BeamBlocks(const FlightNetwork& network);

/// Finds competing effects, to first order: effects that explain the data as
/// well as an estimated unknown if they replace it. Computes the shift of the
/// watched unknowns by this replacement.
///
/// Unknown k of the network has the estimate d_k and the covariance C_kk. For a
/// hypothesis j, Z = N^-1 J^T L. If j replaces k, the estimate d_j and the
/// solution x' are
///
///   s = s_j - A_jk d_k,  A = A_jj + Z_k^T C_kk^-1 Z_k,  A_kj = C_kk^-1 Z_k,
///   d_j = -A^-1 s, x' - x = D_k d_k - (Z_x + D_k Z_k) d_j,  D_k = -C_xk
///   C_kk^-1.
///
/// `score` is that of the library; its shift has the `watched` blocks and then
/// `unknowns`. Only unknowns whose estimates are significant at kFamilyLevel
/// are examined.
std::vector<CompetingEffectCheck> FindCompetingEffects(
    const FlightNetwork& network, const Marginals& marginals, const Library& library,
    const JointScore& score, const std::vector<BlockId>& watched,
    const std::vector<BlockId>& unknowns, const TestFamily& family);

}  // namespace dn::diagnosis_internal
