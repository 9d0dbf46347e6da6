# Precompiles the large headers of the dependencies: once for all layers, once for all programs and
# once for all tests. This halves the compile time. Headers of the project itself are not
# precompiled, so that a wrong include remains an error. If off, the build shows whether every file
# includes the headers it uses.
option(DN_PRECOMPILE "Precompile the heavy headers of the dependencies" ON)

set(DN_EIGEN_ALIGNMENT EIGEN_MAX_ALIGN_BYTES=16 EIGEN_MALLOC_ALREADY_ALIGNED=1)
set(DN_HEAVY_HEADERS
  <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU> <Eigen/QR>
  <Eigen/SVD>
  <algorithm> <array> <cmath> <filesystem> <fstream> <functional> <limits> <map> <memory> <numeric>
  <optional> <sstream> <string> <utility> <vector>)

function(dn_add_precompiled name)
  cmake_parse_arguments(A "POSITION_INDEPENDENT" "" "HEADERS;LINK" ${ARGN})
  if(NOT DN_PRECOMPILE)
    return()
  endif()
  add_library(${name} OBJECT ${PROJECT_SOURCE_DIR}/cmake/precompiled.cc)
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_link_libraries(${name} PRIVATE Eigen3::Eigen Ceres::ceres ${A_LINK} dn_dev_flags)
  target_compile_definitions(${name} PRIVATE ${DN_EIGEN_ALIGNMENT})
  target_precompile_headers(${name} PRIVATE ${DN_HEAVY_HEADERS} ${A_HEADERS})
  if(A_POSITION_INDEPENDENT)
    set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()
endfunction()

# dn_use_precompiled(<target> <name given to dn_add_precompiled>)
function(dn_use_precompiled target name)
  if(DN_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM ${name})
  endif()
endfunction()

dn_add_precompiled(dn_layer_headers POSITION_INDEPENDENT)
dn_add_precompiled(dn_program_headers)
if(DN_BUILD_TESTS)
  dn_add_precompiled(dn_test_headers HEADERS <gtest/gtest.h> <gmock/gmock.h> LINK GTest::gmock)
endif()
