# The documentation, by targets that exist only where their tools are installed:
#
#   docs   the site in build/docs, with the API in build/docs/api      mkdocs (and doxygen)
#   api    the API of the public headers alone, in build/docs/api      doxygen
#   man    dn.1 and dn-<command>.1 from the help of the program        python3
#
# A warning of mkdocs or Doxygen is an error. Nothing is loaded from the network.
set(DN_DOCS_DIR "${PROJECT_SOURCE_DIR}/build/docs" CACHE PATH "Folder of the documentation site")

find_program(DN_MKDOCS mkdocs)
find_package(Doxygen QUIET)
find_package(Python3 QUIET COMPONENTS Interpreter)
mark_as_advanced(DN_MKDOCS)

set(api_command)
if(DOXYGEN_FOUND)
  get_property(folders GLOBAL PROPERTY DN_INCLUDE_FOLDERS)
  list(JOIN folders "\" \\\n  \"" DN_API_FOLDERS)
  configure_file(docs/templates/Doxyfile.in Doxyfile @ONLY)
  set(api_command COMMAND ${CMAKE_COMMAND} -E make_directory ${DN_DOCS_DIR}/api
    COMMAND Doxygen::doxygen ${PROJECT_BINARY_DIR}/Doxyfile)
  add_custom_target(api ${api_command} VERBATIM
    COMMENT "Writing the API to ${DN_DOCS_DIR}/api")
endif()

if(DN_MKDOCS)
  configure_file(docs/templates/mkdocs.yml.in mkdocs.yml @ONLY)
  # mkdocs empties the folder of the site, so that the API comes last.
  add_custom_target(docs
    COMMAND ${DN_MKDOCS} build --strict --clean --config-file ${PROJECT_BINARY_DIR}/mkdocs.yml
    ${api_command} VERBATIM
    COMMENT "Writing the site to ${DN_DOCS_DIR}")
endif()

if(Python3_FOUND AND DN_BUILD_APPS)
  set(DN_MAN_DIR ${PROJECT_BINARY_DIR}/man)
  add_custom_target(man
    COMMAND Python3::Interpreter ${PROJECT_SOURCE_DIR}/cmake/man_pages.py
      $<TARGET_FILE:dn_program> ${DN_MAN_DIR}
    VERBATIM COMMENT "Writing the manual pages to ${DN_MAN_DIR}")
  file(MAKE_DIRECTORY ${DN_MAN_DIR})
  install(DIRECTORY ${DN_MAN_DIR}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1
    FILES_MATCHING PATTERN "*.1")
endif()
