# The tests of dn_add_compile_errors: the compiler must reject every file of compile_errors/. Its
# first error must have the text of the file's first line, "// says: ...". The whole output must be
# short.
# Without their lines marked "// wrong" all files must compile, which shows that these lines are the
# ones rejected. They compile as one file, to parse the headers once. For the same reason the other
# compilations use a precompiled header.
file(GLOB cases ${CASES}/*.cc)
set(longest_output 15)  # lines
get_filename_component(compiler ${CXX_COMPILER} NAME)
set(right ${CMAKE_CURRENT_BINARY_DIR}/compile_errors_${compiler}.cc)
set(precompiled ${CMAKE_CURRENT_BINARY_DIR}/compile_errors_${compiler}.h)
list(TRANSFORM INCLUDES PREPEND -I)

function(compile)
  execute_process(
    COMMAND ${CXX_COMPILER} -std=c++20 ${INCLUDES} -isystem ${EIGEN} ${ARGN}
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  set(result ${result} PARENT_SCOPE)
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(expect_error name expected)
  string(REGEX MATCH "error: [^\n]*" first_error "${output}")
  string(FIND "${first_error}" "${expected}" at)
  if(result EQUAL 0 OR at EQUAL -1)
    message(SEND_ERROR "${name}: expected a first error that says: ${expected}\n${output}")
  endif()
  string(REGEX MATCHALL "\n" lines "${output}")
  list(LENGTH lines length)
  if(length GREATER longest_output)
    message(SEND_ERROR "${name}: the output has ${length} lines:\n${output}")
  endif()
endfunction()

set(all_headers "")
foreach(case IN LISTS cases)
  file(STRINGS ${case} headers REGEX "^#include ")
  list(APPEND all_headers ${headers})
endforeach()
list(REMOVE_DUPLICATES all_headers)
list(JOIN all_headers "\n" all_headers)
file(WRITE ${precompiled} "${all_headers}\n")
compile(-x c++-header ${precompiled} -o ${precompiled}.gch)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "the headers do not compile:\n${output}")
endif()

foreach(case IN LISTS cases)
  get_filename_component(name ${case} NAME_WE)
  file(READ ${case} text)
  string(REGEX MATCH "^// says: ([^\n]*)" first_line "${text}")
  set(expected "${CMAKE_MATCH_1}")
  compile(-fsyntax-only -include ${precompiled} ${case})
  expect_error(${name} "${expected}")
  string(REGEX REPLACE "[^\n]*// wrong\n" "" text "${text}")
  string(APPEND all_right "namespace ${name} {\n#line 1 \"${case}\"\n${text}}\n")
endforeach()
# The headers are included outside the namespaces first, and are skipped inside them.
file(WRITE ${right} "${all_headers}\n${all_right}")
# Clang rejects a wrong class even if nothing uses it, so that only GCC compiles this file.
if(compiler MATCHES clang)
  return()
endif()
compile(-fsyntax-only -include ${precompiled} ${right})
if(NOT result EQUAL 0)
  message(SEND_ERROR "without their wrong lines the files do not compile:\n${output}")
endif()
