#pragma once

#include <dn/network.h>

#include <vector>

#include "linearization.h"

namespace dn::sparse {

/// A symmetric sparse matrix: the lower triangle in compressed columns, with ascending rows.
struct SymmetricCsc {
  int n = 0;
  std::vector<int> column_start;
  std::vector<int> row;
  std::vector<double> value;
};

/// Returns the pattern of the blocks that share a factor, without values.
SymmetricCsc BlockPattern(const UnknownLayout& layout, const Linearization& linearization);
/// Returns the same pattern from the active factors of a network, which need not be linearised.
SymmetricCsc BlockPattern(const UnknownLayout& layout, const Network& network);

}  // namespace dn::sparse
