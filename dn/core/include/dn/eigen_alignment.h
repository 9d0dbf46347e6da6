#pragma once

#include <Eigen/Core>

namespace dn {

/// The library defines this function only for the alignment of Eigen types with which it was built.
/// -mavx2 or -march=native without the CMake targets of dn give another alignment. Such a program
/// would read objects of the library at wrong offsets, and free its memory wrongly. It does not
/// link, and the linker names this function. Link dn::core, or compile with
/// -DEIGEN_MAX_ALIGN_BYTES=16 -DEIGEN_MALLOC_ALREADY_ALIGNED=1.
template <int kBytes, int kMallocIsAligned>
int ProgramAlignsEigenTypesUnlikeTheLibrary();

// Every source that includes this header refers to the function of its own alignment.
[[gnu::used]] static int (*const kExpectedEigenAlignment)() =
    &ProgramAlignsEigenTypesUnlikeTheLibrary<EIGEN_MAX_STATIC_ALIGN_BYTES,
                                             EIGEN_MALLOC_ALREADY_ALIGNED>;

}  // namespace dn
