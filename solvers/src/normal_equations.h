#pragma once

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

/// N = J^T J, with the pattern of its blocks beside it.
struct NormalEquations {
  SymmetricCsc N;
  SymmetricCsc blocks;  ///< pattern only: which blocks of the layout share a factor

  NormalEquations(const UnknownLayout& layout, const Linearization& linearization);
};

}  // namespace dn
