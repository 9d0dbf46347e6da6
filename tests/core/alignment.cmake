# The test core.alignment: a program compiled for AVX must not link with the library unless it has
# the definitions of the CMake target. The linker must then name the function that says why. With the
# definitions it runs, and memory of the library may be freed in the program.
string(REPLACE "," ";" all ${DEFINITIONS})
list(TRANSFORM all PREPEND -D)
list(GET all 0 some)
set(scratch ${CMAKE_CURRENT_BINARY_DIR}/alignment)
file(MAKE_DIRECTORY ${scratch})
foreach(flag IN ITEMS -march=haswell -march=skylake-avx512)
  foreach(have IN ITEMS none some all)
    set(none)
    execute_process(
      COMMAND ${CXX_COMPILER} -std=c++20 -O1 ${flag} ${${have}} -I${INCLUDES} -isystem ${EIGEN}
        ${SOURCE} ${LIBRARY} -o ${scratch}/program
      RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    string(FIND "${output}" "ProgramAlignsEigenTypesUnlikeTheLibrary" at)
    if(have STREQUAL all AND NOT result EQUAL 0)
      message(SEND_ERROR "${flag} ${all} does not link:\n${output}")
    elseif(NOT have STREQUAL all AND (result EQUAL 0 OR at EQUAL -1))
      message(SEND_ERROR "${flag} ${${have}} links, or fails for another reason:\n${output}")
    endif()
  endforeach()
endforeach()
