#pragma once

namespace dn::sparse {

/// Limits BLAS and the OpenMP regions of CHOLMOD to one thread for the calling thread, for the
/// lifetime of the object. The fronts of these networks are too small to parallelise.
///
/// Throws std::bad_alloc if the workspace of OpenBLAS does not fit into memory; OpenBLAS itself
/// would retry forever.
class SerialBlas {
 public:
  SerialBlas();
  ~SerialBlas();
  SerialBlas(const SerialBlas&) = delete;
  SerialBlas& operator=(const SerialBlas&) = delete;

 private:
  int openmp_levels_;
};

}  // namespace dn::sparse
