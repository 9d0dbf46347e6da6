# Defines the imported target dn::OpenBLAS. Debian's Ceres links ATLAS, and CHOLMOD uses the dgemm_
# of the first BLAS in the link order. OpenBLAS is therefore linked before all other libraries, and
# kept although the project itself calls little of it. A test asserts that dgemm_ resolves to
# OpenBLAS.
find_library(DN_OPENBLAS_LIBRARY NAMES openblas)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(DnOpenBLAS REQUIRED_VARS DN_OPENBLAS_LIBRARY)
if(DnOpenBLAS_FOUND AND NOT TARGET dn::OpenBLAS)
  add_library(dn::OpenBLAS INTERFACE IMPORTED)
  target_link_options(dn::OpenBLAS INTERFACE
    "SHELL:-Wl,--push-state,--no-as-needed ${DN_OPENBLAS_LIBRARY} -Wl,--pop-state")
endif()
mark_as_advanced(DN_OPENBLAS_LIBRARY)
