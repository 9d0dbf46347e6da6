#pragma once

#include <dn/builder/flight_network.h>
#include <dn/calibration/candidate_effects.h>
#include <dn/calibration/checks.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <vector>

namespace dn::internal {

/// The effects of the table that are unknowns of a network, besides the boresight.
std::vector<BlockId> EffectUnknowns(const FlightNetwork& network);

/// What watched coordinates are: their blocks and standard deviations.
struct WatchedUnknowns {
  std::vector<BlockId> blocks;
  Eigen::VectorXd sigma;
  bool of_boresight = true;  ///< the block is the boresight
};

/// Effects that explain as well, to first order, what an estimated unknown explains, with what they
/// in its place do to the watched unknowns. With N and its unknown k, estimated as d_k with the
/// covariance C_kk, and Z = N^-1 J^T L of a candidate j, the candidate without k has
///
///   s = s_j - A_jk d_k,  A = A_jj + Z_k^T C_kk^-1 Z_k,  A_kj = C_kk^-1 Z_k,  estimate d_j = -A^-1 s,
///   x' - x = D_k d_k - (Z_x + D_k Z_k) d_j,  D_k = -C_xk C_kk^-1.
///
/// `score`: of the candidates, its shift of the watched blocks and, below them, of `unknowns`. Only
/// unknowns are looked at whose estimates the data ask for at kFamilyLevel (for `tests` tests).
std::vector<RivalCheck> FindRivals(const FlightNetwork& network, const Marginals& marginals,
                                   const std::vector<CandidateEffect>& candidates,
                                   const JointScore& score, const WatchedUnknowns& watched,
                                   const std::vector<BlockId>& unknowns, double tests);

}  // namespace dn::internal
