#include <dn/stopwatch.h>

#include "sparse/shared_analysis_impl.h"

namespace dn {

void SharedAnalysis::Impl::Assemble(const UnknownLayout& layout,
                                    const Linearization& linearization) {
  analyze_s = 0.0;
  if (equations && offset_ == layout.offset && equations->Place(linearization)) {
    equations->Assemble(layout, linearization);
    return;
  }
  cholesky.reset();
  equations = std::make_unique<sparse::NormalEquations>(layout, linearization);
  const Stopwatch watch;
  cholesky = std::make_unique<sparse::Cholesky>(equations->N, equations->blocks, layout);
  analyze_s = watch.seconds();
  offset_ = layout.offset;
}

SharedAnalysis::SharedAnalysis() : impl_(std::make_unique<Impl>()) {}
SharedAnalysis::~SharedAnalysis() = default;

}  // namespace dn
