# The test core.alignment: a program compiled for AVX must not link with the library unless it has
# the definitions of the CMake target. The linker must then name the function that says why. The test
# package.find_package runs a program for the instruction set of its machine.
string(REPLACE "," ";" flags_all ${DEFINITIONS})
list(TRANSFORM flags_all PREPEND -D)
list(GET flags_all 0 flags_some)
set(flags_none)
set(scratch ${CMAKE_CURRENT_BINARY_DIR}/alignment)
file(MAKE_DIRECTORY ${scratch})
foreach(flag IN ITEMS -march=haswell -march=skylake-avx512)
  foreach(have IN ITEMS none some all)
    execute_process(
      COMMAND ${CXX_COMPILER} -std=c++20 -O1 ${flag} ${flags_${have}} -I${INCLUDES} -isystem ${EIGEN}
        ${SOURCE} ${LIBRARY} -o ${scratch}/program
      RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    string(FIND "${output}" "ProgramAlignsEigenTypesUnlikeTheLibrary" at)
    if(have STREQUAL all AND NOT result EQUAL 0)
      message(SEND_ERROR "${flag} ${flags_all} does not link:\n${output}")
    elseif(NOT have STREQUAL all AND (result EQUAL 0 OR at EQUAL -1))
      message(SEND_ERROR "${flag} ${flags_${have}} links, or fails for another reason:\n${output}")
    endif()
  endforeach()
endforeach()
