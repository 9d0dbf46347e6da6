#pragma once

#include <dn/builder/flight_network.h>
#include <dn/network.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace dn::internal {

/// Data of a flight that are taken out together, so that the others predict them.
struct Fold {
  std::vector<std::pair<double, double>> pairs_t_s;  ///< epochs of both ends
  std::vector<std::size_t> gnss_epochs;              ///< of Flight::gnss

  bool empty() const { return pairs_t_s.empty() && gnss_epochs.empty(); }
};

/// Folds of two kinds: the pairs of a tile of the ground, tiles of equally many pairs; and outages
/// of GNSS of 30 s, one every 180 s. Neighbours share the error of the trajectory, so that single
/// data would be predicted by those beside them. Fewer than `of_each_kind` where the data are few.
std::vector<Fold> MakeFolds(const FlightNetwork& network, int of_each_kind);

/// A factor of a fold, and the block of the position or velocity that it measures: the derivative
/// by that block is the root W of its weight.
struct FoldFactor {
  FactorId id = -1;
  BlockId measured = -1;
};

/// The factors of a fold in a network, active or not. Those of two networks of one flight stand in
/// the same order; a measurement that a network has not has the id -1.
std::vector<FoldFactor> FactorsOf(const Fold& fold, const FlightNetwork& network);

}  // namespace dn::internal
