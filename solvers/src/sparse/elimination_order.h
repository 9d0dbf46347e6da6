#pragma once

#include <vector>

#include "sparse/block_pattern.h"

namespace dn::sparse {

/// Elimination order of the blocks of a network and its cost.
struct EliminationOrder {
  std::vector<int> position;  ///< block that is eliminated first, second, ...
  /// Cost of a block factorisation; one operation multiplies and adds two blocks.
  double block_operations = 0.0;
  bool dissected = false;

  /// Returns the estimated number of scalar multiply-add operations to factor `unknowns` unknowns
  /// in blocks of equal size.
  double operations(int unknowns) const;
};

/// Returns an order with little fill-in. Approximate minimum degree is usually the best order for
/// chains in time. If it leaves an expensive factorisation, as for hours of overlapping strips,
/// nested dissection is also tried and the cheaper order is returned. Throws std::bad_alloc.
EliminationOrder FindEliminationOrder(const SymmetricCsc& blocks, int unknowns);

}  // namespace dn::sparse
