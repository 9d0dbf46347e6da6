# Defines the imported target dn::GeographicLib. Debian's libgeographiclib-dev has no CMake package.
find_path(DN_GEOGRAPHICLIB_INCLUDE_DIR GeographicLib/LocalCartesian.hpp)
find_library(DN_GEOGRAPHICLIB_LIBRARY NAMES GeographicLib Geographic)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(DnGeographicLib
  REQUIRED_VARS DN_GEOGRAPHICLIB_LIBRARY DN_GEOGRAPHICLIB_INCLUDE_DIR)
if(DnGeographicLib_FOUND AND NOT TARGET dn::GeographicLib)
  add_library(dn::GeographicLib UNKNOWN IMPORTED)
  set_target_properties(dn::GeographicLib PROPERTIES
    IMPORTED_LOCATION "${DN_GEOGRAPHICLIB_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${DN_GEOGRAPHICLIB_INCLUDE_DIR}")
endif()
mark_as_advanced(DN_GEOGRAPHICLIB_INCLUDE_DIR DN_GEOGRAPHICLIB_LIBRARY)
