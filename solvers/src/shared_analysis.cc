#include <chrono>

#include "seconds_since.h"
#include "shared_analysis_impl.h"

namespace dn {

void SharedAnalysis::Impl::Assemble(const UnknownLayout& layout,
                                    const Linearization& linearization) {
  analyze_s = 0.0;
  if (equations && offset_ == layout.offset && equations->Place(linearization)) {
    equations->Assemble(layout, linearization);
    return;
  }
  cholesky.reset();
  equations = std::make_unique<NormalEquations>(layout, linearization);
  const auto start = std::chrono::steady_clock::now();
  cholesky = std::make_unique<SparseCholesky>(equations->N, equations->blocks, layout);
  analyze_s = SecondsSince(start);
  offset_ = layout.offset;
}

SharedAnalysis::SharedAnalysis() : impl_(std::make_unique<Impl>()) {}
SharedAnalysis::~SharedAnalysis() = default;

}  // namespace dn
