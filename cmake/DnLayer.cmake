#   dn_add_layer(<name> DIR <folder> SOURCES <files under folder/src> PUBLIC <targets>
#                [PRIVATE <targets>] [EXPORT <set>])
#
# Adds the library of a layer. Each layer has its own include root, so that an include against the
# layer diagram does not compile. Call it from the CMakeLists.txt of the folder; DIR is relative to
# the project root. EXPORT is the set of exported targets. Layers with fewer
# dependencies (dnTargets) or more (dnPclTargets) than the others (dnFlightTargets) name theirs.
function(dn_add_layer name)
  cmake_parse_arguments(A "" "DIR;EXPORT" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  if(NOT A_EXPORT)
    set(A_EXPORT dnFlightTargets)
  endif()
  list(TRANSFORM A_SOURCES PREPEND "${PROJECT_SOURCE_DIR}/${A_DIR}/src/")
  add_library(dn_${name} ${A_SOURCES})
  add_library(dn::${name} ALIAS dn_${name})
  set_target_properties(dn_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_compile_features(dn_${name} PUBLIC cxx_std_20)
  target_include_directories(dn_${name}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/${A_DIR}/include>
           $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${PROJECT_SOURCE_DIR}/${A_DIR}/src)
  target_link_libraries(dn_${name}
    PUBLIC ${A_PUBLIC}
    PRIVATE ${A_PRIVATE} $<BUILD_INTERFACE:dn_dev_flags>)
  dn_use_precompiled(dn_${name} dn_layer_headers)
  dn_guide_fuzzer(${name})
  set_property(GLOBAL APPEND PROPERTY DN_INCLUDE_FOLDERS ${PROJECT_SOURCE_DIR}/${A_DIR}/include)
  add_dependencies(dn_libraries dn_${name})
  install(TARGETS dn_${name} EXPORT ${A_EXPORT}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${A_DIR}/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endfunction()

# dn_register_tests(<program> LABEL <label> [properties of its tests...]): the tests of a program
# run in one process, where they share simulated flights. For ctest they are one test with the name
# of the program.
# Tests with ManyRuns in the name of their suite take long: they are tests of ctest by themselves.
# Those with SlowRuns have the label slow, and exist only with DN_BUILD_SLOW_TESTS.
function(dn_register_tests name)
  cmake_parse_arguments(A "" "LABEL" "" ${ARGN})
  add_test(NAME ${name} COMMAND ${name} --gtest_filter=-*ManyRuns*:*SlowRuns*)
  set_tests_properties(${name} PROPERTIES
    LABELS ${A_LABEL} TIMEOUT 1200 COST 10 ${A_UNPARSED_ARGUMENTS})
  gtest_discover_tests(${name} NO_PRETTY_VALUES TEST_FILTER *ManyRuns* DISCOVERY_TIMEOUT 120
    PROPERTIES LABELS ${A_LABEL} TIMEOUT 600 ${A_UNPARSED_ARGUMENTS})
  if(DN_BUILD_SLOW_TESTS)
    gtest_discover_tests(${name} NO_PRETTY_VALUES TEST_FILTER *SlowRuns* DISCOVERY_TIMEOUT 120
      TEST_LIST ${name}_slow PROPERTIES LABELS slow TIMEOUT 900 ${A_UNPARSED_ARGUMENTS})
  endif()
endfunction()

#   dn_add_test(<name> SOURCES <files> LINK <targets>
#               [LABEL <unit|property|golden|example|cli|package|slow>] [INCLUDE <folders>])
#
# Adds one GoogleTest program from all sources of a folder with the same label, and its tests
# (dn_register_tests). With CMAKE_UNITY_BUILD several sources are compiled together; they share the
# namespace dn::<layer>_test, in which a name has one meaning. INCLUDE: folders of headers that only
# the layer itself and its tests use.
function(dn_add_test name)
  cmake_parse_arguments(A "" "LABEL" "SOURCES;LINK;INCLUDE" ${ARGN})
  if(NOT A_LABEL)
    set(A_LABEL unit)
  endif()
  if(A_LABEL STREQUAL slow AND NOT DN_BUILD_SLOW_TESTS)
    return()
  endif()
  add_executable(${name} ${A_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests ${A_INCLUDE})
  target_link_libraries(${name} PRIVATE ${A_LINK} GTest::gmock GTest::gtest_main dn_dev_flags)
  dn_use_precompiled(${name} dn_test_headers)
  target_compile_definitions(${name} PRIVATE DN_SHARED_DATA_DIR="${DN_SHARED_DATA_DIR}")
  if(A_LABEL STREQUAL slow)  # .ci/run starts only the other programs one by one
    set_target_properties(${name} PROPERTIES
      RUNTIME_OUTPUT_DIRECTORY ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/slow)
  endif()
  dn_register_tests(${name} LABEL ${A_LABEL})
endfunction()
