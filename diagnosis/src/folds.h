#pragma once

#include <dn/builder/flight_network.h>
#include <dn/network.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace dn::diagnosis_internal {

/// Data of a flight that are held out together and predicted from all other data.
struct Fold {
  std::vector<std::pair<double, double>> pairs_t_s;  ///< times of both ends
  std::vector<std::size_t> gnss_epochs;              ///< indices of Flight::gnss epochs

  bool empty() const { return pairs_t_s.empty() && gnss_epochs.empty(); }
};

/// Makes folds of two kinds: tiles of the ground with equal numbers of pairs, and GNSS outages of
/// 30 s, one every 180 s. Neighbouring data share the trajectory error, so that neighbours would
/// predict a single held-out measurement. Returns fewer than `num_per_kind` of a kind if the data
/// are few.
std::vector<Fold> MakeFolds(const FlightNetwork& network, int num_per_kind);

/// A factor of a fold, and the block of the position or velocity that it measures. The derivative
/// with respect to that block is the root W of the factor's weight.
struct FoldFactor {
  FactorId id = -1;
  BlockId measured = -1;
};

/// Returns the factors of a fold in a network, active or not. Two networks of one flight return
/// them in the same order. A measurement that the network lacks has the id -1.
std::vector<FoldFactor> FindFoldFactors(const Fold& fold, const FlightNetwork& network);

}  // namespace dn::diagnosis_internal
