#include <dn/eigen_alignment.h>

namespace dn {

template <int kBytes>
int ProgramAlignsEigenTypesUnlikeTheLibrary() {
  return kBytes;
}

template int ProgramAlignsEigenTypesUnlikeTheLibrary<EIGEN_MAX_STATIC_ALIGN_BYTES>();

}  // namespace dn
