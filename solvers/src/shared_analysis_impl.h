#pragma once

#include <dn/solvers/shared_analysis.h>

#include <memory>

#include "normal_equations.h"
#include "sparse_cholesky.h"

namespace dn {

struct SharedAnalysis::Impl {
  std::unique_ptr<NormalEquations> equations;
  std::unique_ptr<SparseCholesky> cholesky;
  double analyze_s = 0.0;  ///< of the last Assemble; 0 where the analysis served

  /// Assembles the normal equations, with the order and analysis of the last network where they
  /// serve this one as well.
  void Assemble(const UnknownLayout& layout, const Linearization& linearization);

 private:
  std::vector<int> offset_;  ///< of the layout analysed
};

}  // namespace dn
