# Defines the imported target dn::BLAS: OpenBLAS, or the libraries of DN_BLAS_LIBRARIES. Debian's
# Ceres links ATLAS, and CHOLMOD uses the dgemm_ of the first BLAS in the link order. BLAS is
# therefore linked before all other libraries, and kept although the project itself calls little of
# it. A test asserts that dgemm_ comes from it.
if(DN_BLAS_LIBRARIES)
  set(_dn_blas ${DN_BLAS_LIBRARIES})
else()
  find_library(DN_OPENBLAS_LIBRARY NAMES openblas)
  set(_dn_blas ${DN_OPENBLAS_LIBRARY})
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(DnBlas REQUIRED_VARS _dn_blas)
if(DnBlas_FOUND AND NOT TARGET dn::BLAS)
  list(GET _dn_blas 0 _dn_blas_first)
  get_filename_component(DN_BLAS_NAME "${_dn_blas_first}" NAME_WE)
  list(JOIN _dn_blas " " _dn_blas_words)
  add_library(dn::BLAS INTERFACE IMPORTED)
  target_link_options(dn::BLAS INTERFACE
    "SHELL:-Wl,--push-state,--no-as-needed ${_dn_blas_words} -Wl,--pop-state")
endif()
mark_as_advanced(DN_OPENBLAS_LIBRARY)
