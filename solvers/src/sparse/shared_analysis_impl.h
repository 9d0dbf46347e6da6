#pragma once

#include <dn/solvers/shared_analysis.h>

#include <memory>

#include "sparse/cholesky.h"
#include "sparse/normal_equations.h"

namespace dn {

struct SharedAnalysis::Impl {
  std::unique_ptr<sparse::NormalEquations> equations;
  std::unique_ptr<sparse::Cholesky> cholesky;
  double analyze_s = 0.0;  ///< time of the last Assemble; 0 if the analysis was reused

  /// Assembles the normal equations. Reuses the order and analysis of the last network if they fit
  /// this one.
  void Assemble(const UnknownLayout& layout, const Linearization& linearization);

 private:
  std::vector<int> offset_;  ///< offsets of the analysed layout
};

}  // namespace dn
