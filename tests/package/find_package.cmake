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

# The program in the README is part of the outside project.
file(READ ${DN_SOURCE_DIR}/README.md readme)
string(FIND "${readme}" "```cpp\n" begin)
string(SUBSTRING "${readme}" ${begin} -1 readme)
string(SUBSTRING "${readme}" 7 -1 readme)
string(FIND "${readme}" "```" end)
string(SUBSTRING "${readme}" 0 ${end} readme)
file(WRITE ${SCRATCH_DIR}/readme.cc "${readme}")

run(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${SCRATCH_DIR}/build -G ${GENERATOR}
  -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_BUILD_TYPE=Release
  -D CMAKE_C_COMPILER=${C_COMPILER} -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
  -D CMAKE_CXX_FLAGS=${CXX_FLAGS} -D README_PROGRAM=${SCRATCH_DIR}/readme.cc)
run(${CMAKE_COMMAND} --build ${SCRATCH_DIR}/build)
foreach(program IN ITEMS consumer readme)
  run(${SCRATCH_DIR}/build/${program})
  message(STATUS "${program}: ${output}")
endforeach()
