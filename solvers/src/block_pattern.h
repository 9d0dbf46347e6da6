#pragma once

#include <dn/network.h>

#include <vector>

#include "linearization.h"

namespace dn {

/// A symmetric matrix, its lower triangle by compressed columns with ascending rows.
struct SymmetricCsc {
  int n = 0;
  std::vector<int> column_start;
  std::vector<int> row;
  std::vector<double> value;
};

/// Which blocks of the layout share a factor: a pattern without values.
SymmetricCsc BlockPattern(const UnknownLayout& layout, const Linearization& linearization);
/// The same from the active factors of a network, which need not be linearised.
SymmetricCsc BlockPattern(const UnknownLayout& layout, const Network& network);

}  // namespace dn
