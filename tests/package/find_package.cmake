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
file(GLOB_RECURSE exported ${prefix}/*/dnTargets*.cmake)
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

# Writes the first code block of a language in the README to a file.
function(readme_block language out)
  file(READ ${DN_SOURCE_DIR}/README.md readme)
  string(FIND "${readme}" "```${language}\n" begin)
  string(SUBSTRING "${readme}" ${begin} -1 readme)
  string(FIND "${readme}" "\n" line)
  math(EXPR line "${line} + 1")
  string(SUBSTRING "${readme}" ${line} -1 readme)
  string(FIND "${readme}" "```" end)
  string(SUBSTRING "${readme}" 0 ${end} readme)
  file(WRITE ${out} "${readme}")
endfunction()

set(compilers -G ${GENERATOR} -D CMAKE_C_COMPILER=${C_COMPILER} -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
  -D CMAKE_CXX_FLAGS=${CXX_FLAGS} -D CMAKE_PREFIX_PATH=${prefix})

# Builds the program in the README with the CMake code in the README, as on a machine without PCL.
readme_block(cpp ${SCRATCH_DIR}/readme/main.cc)
readme_block(cmake ${SCRATCH_DIR}/readme/CMakeLists.txt)
run(${CMAKE_COMMAND} -S ${SCRATCH_DIR}/readme -B ${SCRATCH_DIR}/readme/build ${compilers}
  -D CMAKE_DISABLE_FIND_PACKAGE_PCL=ON)
run(${CMAKE_COMMAND} --build ${SCRATCH_DIR}/readme/build)
run(${SCRATCH_DIR}/readme/build/mine)
message(STATUS "readme: ${output}")

# Builds a project that uses several components, including the one with PCL if it was built.
run(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${SCRATCH_DIR}/build ${compilers}
  -D CMAKE_BUILD_TYPE=Release -D WITH_PCL=${PCL_LIBRARY})
run(${CMAKE_COMMAND} --build ${SCRATCH_DIR}/build)
run(${SCRATCH_DIR}/build/consumer)
message(STATUS "consumer: ${output}")

# A missing component must be reported by name.
execute_process(
  COMMAND ${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${SCRATCH_DIR}/none ${compilers} -D COMPONENT=radar
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
string(FIND "${output}" "radar" at)
if(result EQUAL 0 OR at EQUAL -1)
  message(FATAL_ERROR "find_package(dn) did not report the missing component radar:\n${output}")
endif()
