#include "sparse/cholmod_support.h"

#include <dn/error.h>

#include <new>
#include <string>

namespace dn::sparse {

CholmodCommon::CholmodCommon() {
  cholmod_start(&common_);
  common_.print = 0;
  common_.try_catch = 1;
}

CholmodCommon::~CholmodCommon() { cholmod_finish(&common_); }

void CholmodCommon::Check(const char* step) const {
  if (common_.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  if (common_.status == CHOLMOD_TOO_LARGE) {
    throw InvalidInput("marginals: the factor of the normal matrix is too large; use fewer nodes");
  }
  if (common_.status < CHOLMOD_OK) {
    throw Error(std::string("marginals: CHOLMOD failed while ") + step + ", status " +
                std::to_string(common_.status));
  }
}

void FreeCholmodFactor::operator()(cholmod_factor* factor) const noexcept {
  CholmodCommon common;
  cholmod_free_factor(&factor, common.get());
}

cholmod_sparse View(const SymmetricCsc& A) {
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(A.n);
  view.nzmax = A.row.size();
  view.p = const_cast<int*>(A.column_start.data());
  view.i = const_cast<int*>(A.row.data());
  view.x = A.value.empty() ? nullptr : const_cast<double*>(A.value.data());
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = A.value.empty() ? CHOLMOD_PATTERN : CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

}  // namespace dn::sparse
