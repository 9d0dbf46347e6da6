#pragma once

namespace dn {

/// One thread in BLAS, and in what CHOLMOD does by OpenMP, for the calling thread while it lives:
/// the fronts of these networks are too small to share.
///
/// Throws std::bad_alloc where the work space of OpenBLAS, which asks for it again and again for
/// ever, does not fit into memory.
class SerialBlas {
 public:
  SerialBlas();
  ~SerialBlas();
  SerialBlas(const SerialBlas&) = delete;
  SerialBlas& operator=(const SerialBlas&) = delete;

 private:
  int openmp_levels_;
};

}  // namespace dn
