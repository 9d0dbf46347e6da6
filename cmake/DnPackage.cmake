# Installs the CMake package: after `cmake --install`, find_package(dn) provides the targets
# dn::<layer>.
include(CMakePackageConfigHelpers)

set(DN_CONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/dn)

install(EXPORT dnTargets NAMESPACE dn:: DESTINATION ${DN_CONFIG_DIR})
install(EXPORT dnFlightTargets NAMESPACE dn:: DESTINATION ${DN_CONFIG_DIR})
if(DN_WITH_PCL)
  install(EXPORT dnPclTargets NAMESPACE dn:: DESTINATION ${DN_CONFIG_DIR})
endif()

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/dnConfig.cmake.in ${PROJECT_BINARY_DIR}/dnConfig.cmake
  INSTALL_DESTINATION ${DN_CONFIG_DIR})
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/dnConfigVersion.cmake COMPATIBILITY SameMinorVersion)

install(FILES
  ${PROJECT_BINARY_DIR}/dnConfig.cmake
  ${PROJECT_BINARY_DIR}/dnConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/cmake/FindDnGeographicLib.cmake
  ${PROJECT_SOURCE_DIR}/cmake/FindDnBlas.cmake
  DESTINATION ${DN_CONFIG_DIR})
install(FILES LICENSE LICENSE.note DESTINATION ${CMAKE_INSTALL_DOCDIR})
