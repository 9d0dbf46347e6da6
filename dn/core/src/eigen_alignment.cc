#include <dn/eigen_alignment.h>

namespace dn {

template <int kBytes, int kMallocIsAligned>
int ProgramAlignsEigenTypesUnlikeTheLibrary() {
  return kMallocIsAligned != 0 ? kBytes : -kBytes;
}

template int ProgramAlignsEigenTypesUnlikeTheLibrary<EIGEN_MAX_STATIC_ALIGN_BYTES,
                                                     EIGEN_MALLOC_ALREADY_ALIGNED>();

}  // namespace dn
