# Imported target dn::OpenBLAS. Debian's Ceres drags in ATLAS, and CHOLMOD's dgemm_ binds to whichever
# BLAS comes first: so OpenBLAS is put ahead of every library, and kept although nothing of ours calls
# most of it. A test asserts that dgemm_ resolves to it.
find_library(DN_OPENBLAS_LIBRARY NAMES openblas)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(DnOpenBLAS REQUIRED_VARS DN_OPENBLAS_LIBRARY)
if(DnOpenBLAS_FOUND AND NOT TARGET dn::OpenBLAS)
  add_library(dn::OpenBLAS INTERFACE IMPORTED)
  target_link_options(dn::OpenBLAS INTERFACE
    "SHELL:-Wl,--push-state,--no-as-needed ${DN_OPENBLAS_LIBRARY} -Wl,--pop-state")
endif()
mark_as_advanced(DN_OPENBLAS_LIBRARY)
