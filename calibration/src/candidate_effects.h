#pragma once

#include <dn/calibration/candidate_effects.h>

namespace dn::internal {

void AddGnssCandidates(const FlightNetwork& network, std::vector<CandidateEffect>* effects);
void AddInertialCandidates(const FlightNetwork& network, std::vector<CandidateEffect>* effects);
void AddLidarCandidates(const FlightNetwork& network, std::vector<CandidateEffect>* effects);

/// A held block as an effect: its change from the value at which it is held.
EffectModel ModelOfBlock(const Network& net, const std::vector<FactorId>& factors, BlockId block);

/// The values of a factor's blocks.
std::vector<const double*> ValuesOf(const Network& net, FactorId factor);

}  // namespace dn::internal
