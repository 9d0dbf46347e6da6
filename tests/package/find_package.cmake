# The test package.find_package; variables come from CMakeLists.txt beside this file.
set(prefix ${SCRATCH_DIR}/prefix)
file(REMOVE_RECURSE ${SCRATCH_DIR})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nfailed with ${result}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

if(PCL_LIBRARY)  # as after ./bootstrap, which builds the program alone
  file(REMOVE ${PCL_LIBRARY})
endif()
run(${CMAKE_COMMAND} --install ${DN_BINARY_DIR} --prefix ${prefix})

# The flags of our own builds and the paths of this tree must not reach a user.
file(GLOB_RECURSE exported ${prefix}/*/dnTargets*.cmake)
if(NOT exported)
  message(FATAL_ERROR "no dnTargets*.cmake under ${prefix}")
endif()
foreach(file IN LISTS exported)
  file(READ ${file} text)
  foreach(forbidden IN ITEMS "dn_dev_flags" "-Wshadow" "-fsanitize" "${DN_SOURCE_DIR}/" "${DN_BINARY_DIR}/lib")
    string(FIND "${text}" "${forbidden}" at)
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${file} contains ${forbidden}")
    endif()
  endforeach()
endforeach()

# The text of the README's first block of a language.
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

# The README's program by the README's CMake lines, on a machine without PCL.
readme_block(cpp ${SCRATCH_DIR}/readme/main.cc)
readme_block(cmake ${SCRATCH_DIR}/readme/CMakeLists.txt)
run(${CMAKE_COMMAND} -S ${SCRATCH_DIR}/readme -B ${SCRATCH_DIR}/readme/build ${compilers}
  -D CMAKE_DISABLE_FIND_PACKAGE_PCL=ON)
run(${CMAKE_COMMAND} --build ${SCRATCH_DIR}/readme/build)
run(${SCRATCH_DIR}/readme/build/mine)
message(STATUS "readme: ${output}")

# A project of several layers, that of PCL among them where it was built.
run(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${SCRATCH_DIR}/build ${compilers}
  -D CMAKE_BUILD_TYPE=Release -D WITH_PCL=${PCL_LIBRARY})
run(${CMAKE_COMMAND} --build ${SCRATCH_DIR}/build)
run(${SCRATCH_DIR}/build/consumer)
message(STATUS "consumer: ${output}")

# What there is not, is said.
execute_process(
  COMMAND ${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${SCRATCH_DIR}/none ${compilers} -D COMPONENT=radar
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
string(FIND "${output}" "radar" at)
if(result EQUAL 0 OR at EQUAL -1)
  message(FATAL_ERROR "a component that there is not was found:\n${output}")
endif()
