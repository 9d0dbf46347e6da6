# Runs the test package.find_package. CMakeLists.txt in this folder sets the variables.
set(prefix ${SCRATCH_DIR}/prefix)
file(REMOVE_RECURSE ${SCRATCH_DIR})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nfailed with ${result}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

if(PCL_LIBRARY)  # this library is also missing after ./bootstrap, which builds only the program
  file(REMOVE ${PCL_LIBRARY})
endif()
run(${CMAKE_COMMAND} --install ${DN_BINARY_DIR} --prefix ${prefix})

# The exported targets must not contain development flags or paths of this source tree.
file(GLOB_RECURSE exported ${prefix}/*/dn*Targets*.cmake)
if(NOT exported)
  message(FATAL_ERROR "no dnTargets*.cmake under ${prefix}")
endif()
foreach(file IN LISTS exported)
  file(READ ${file} text)
  foreach(forbidden IN ITEMS "dn_dev_flags" "-Wshadow" "-fsanitize" "${DN_SOURCE_DIR}/" "${DN_BINARY_DIR}/lib")
    string(FIND "${text}" "${forbidden}" at)
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${file} must not contain ${forbidden}")
    endif()
  endforeach()
endforeach()

# The text of the block number `index` (from 0) of a language in a page.
function(page_block page language index out)
  file(READ ${DN_SOURCE_DIR}/${page} text)
  foreach(i RANGE ${index})
    string(FIND "${text}" "```${language}\n" begin)
    if(begin EQUAL -1)
      message(FATAL_ERROR "${page} has no ${language} block number ${index}")
    endif()
    string(SUBSTRING "${text}" ${begin} -1 text)
    string(FIND "${text}" "\n" line)
    math(EXPR line "${line} + 1")
    string(SUBSTRING "${text}" ${line} -1 text)
  endforeach()
  string(FIND "${text}" "```" end)
  string(SUBSTRING "${text}" 0 ${end} text)
  set(${out} "${text}" PARENT_SCOPE)
endfunction()

set(compilers -G ${GENERATOR} -D CMAKE_C_COMPILER=${C_COMPILER} -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
  -D CMAKE_CXX_FLAGS=${CXX_FLAGS} -D CMAKE_PREFIX_PATH=${prefix})

# The programs of the README and of the tutorial use the CMake lines of the tutorial, on a machine
# without PCL. The tutorial links more layers in its last program.
set(tutorial docs/tutorials/build-your-own-network.md)
page_block(${tutorial} cmake 0 lists)
page_block(${tutorial} cmake 1 more_layers)
set(tutorial_lists "${lists}")

# Configures the project in `folder`, to be built with the others by build_all.
set(folders "")
function(configure folder build)
  run(${CMAKE_COMMAND} -S ${folder} -B ${build} ${compilers} ${ARGN})
  list(APPEND folders ${build})
  set(folders "${folders}" PARENT_SCOPE)
endfunction()

# Builds the configured projects in parallel, because each of them has one file that takes long.
function(build_all)
  cmake_host_system_information(RESULT cores QUERY NUMBER_OF_LOGICAL_CORES)
  list(JOIN folders "\n" lines)
  file(WRITE ${SCRATCH_DIR}/folders "${lines}")
  run(xargs --arg-file ${SCRATCH_DIR}/folders -n 1 -P ${cores} ${CMAKE_COMMAND} --build)
endfunction()

set(pages "")
function(configure_page name page index lists output_has)
  set(folder ${SCRATCH_DIR}/${name})
  page_block(${page} cpp ${index} program)
  file(WRITE ${folder}/main.cc "${program}")
  file(WRITE ${folder}/CMakeLists.txt "${lists}")
  configure(${folder} ${folder}/build -D CMAKE_DISABLE_FIND_PACKAGE_PCL=ON)
  set(folders "${folders}" PARENT_SCOPE)
  list(APPEND pages ${name})
  set(pages "${pages}" PARENT_SCOPE)
  set(${name}_page "${page}" PARENT_SCOPE)
  set(${name}_output_has "${output_has}" PARENT_SCOPE)
endfunction()

function(run_page name)
  run(${SCRATCH_DIR}/${name}/build/mine)
  message(STATUS "${name}: ${output}")
  if(NOT output MATCHES "${${name}_output_has}")
    message(FATAL_ERROR "${${name}_page}: its program no longer prints ${${name}_output_has}")
  endif()
endfunction()

configure_page(readme README.md 0 "${lists}" "z = [0-9.]+ \\+- 0\\.0[0-9] m")
configure_page(tutorial_unknown ${tutorial} 0 "${lists}" "5 stations: z = 9[45].*3 stations: .*offset")
configure_page(tutorial_factor ${tutorial} 1 "${lists}" "largest residual: .*distance.*sigma0")
configure_page(from_ceres docs/guides/coming-from-ceres.md 0 "${lists}"
  "x = 10.000 m, sigma of the half angle 0.00224.*x = 10.000 m, sigma of the angle 0.00447")
configure_page(from_gtsam docs/guides/coming-from-gtsam.md 0 "${lists}" "converged: x1 at 2.00 0.00")
string(REGEX REPLACE "target_link_libraries[^\n]*\n" "${more_layers}" lists "${lists}")
configure_page(tutorial_flight ${tutorial} 2 "${lists}" "with the altimeter.*altimeter offset [12]\\.[0-9]+ \\+-")

# A project that names its component needs only the dependencies of networks. It is compiled for the
# instruction set of this machine.
string(REPLACE "find_package(dn 0.1 REQUIRED)" "find_package(dn 0.1 REQUIRED COMPONENTS solvers)"
  networks "${tutorial_lists}")
if(networks STREQUAL tutorial_lists)
  message(FATAL_ERROR "${tutorial}: the CMake lines have no find_package(dn 0.1 REQUIRED)")
endif()
set(without)
foreach(package IN ITEMS yaml-cpp nlohmann_json fmt DnGeographicLib PROJ)
  list(APPEND without -D CMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
set(all_flags ${compilers})
list(APPEND compilers ${without} "-D" "CMAKE_CXX_FLAGS=${CXX_FLAGS} -march=native")
configure_page(networks README.md 0 "${networks}" "z = [0-9.]+ \\+- 0\\.0[0-9] m")
set(compilers ${all_flags})

# A project that uses several components, including the one with PCL if it was built.
configure(${CONSUMER_DIR} ${SCRATCH_DIR}/build -D CMAKE_BUILD_TYPE=Release -D WITH_PCL=${PCL_LIBRARY})

build_all()
foreach(page IN LISTS pages)
  run_page(${page})
endforeach()
run(${SCRATCH_DIR}/build/consumer)
message(STATUS "consumer: ${output}")

# Programs like those of users.
run(${CMAKE_COMMAND} -S ${PROGRAMS_DIR} -B ${SCRATCH_DIR}/programs ${compilers}
  -D CMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${SCRATCH_DIR}/programs --parallel)
run(${CMAKE_CTEST_COMMAND} --test-dir ${SCRATCH_DIR}/programs --output-on-failure)

# A missing component must be reported by name.
execute_process(
  COMMAND ${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${SCRATCH_DIR}/none ${compilers} -D COMPONENT=radar
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
string(FIND "${output}" "radar" at)
if(result EQUAL 0 OR at EQUAL -1)
  message(FATAL_ERROR "find_package(dn) did not report the missing component radar:\n${output}")
endif()
