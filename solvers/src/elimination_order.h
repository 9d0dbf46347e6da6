#pragma once

#include <vector>

#include "block_pattern.h"

namespace dn {

/// In which order the blocks of a network are eliminated.
struct EliminationOrder {
  std::vector<int> position;  ///< of the block that goes first, second, ...
  /// Of a factorisation by blocks, each a multiplication and an addition of two blocks.
  double block_operations = 0.0;
  bool dissected = false;

  /// Of a factorisation of `unknowns` in blocks of about one size, multiplications and additions.
  double operations(int unknowns) const;
};

/// An order that fills little: approximate minimum degree, which is hard to beat along time. Where
/// it leaves much to do, as in hours of strips that overlap, the network is dissected as well, and
/// the better order is taken. Throws std::bad_alloc.
EliminationOrder FindEliminationOrder(const SymmetricCsc& blocks, int unknowns);

}  // namespace dn
